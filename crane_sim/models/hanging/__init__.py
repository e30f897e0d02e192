"""What cranes share whose load hangs below any support: layout of the state, support and winch, exchange of loads."""
