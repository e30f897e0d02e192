"""Equations traced into code: a Python function called with symbols notes what it would compute.

`graph` holds the list of instructions, `operations` what equations call beside arithmetic,
`function` traces; from a traced function come `machine_code`, `c_source` and `derivatives`. The
same Python function, called with floats, computes.
"""
