"""Parts of the tracking laws: measurement, tracker, suspension points and what drives them."""
