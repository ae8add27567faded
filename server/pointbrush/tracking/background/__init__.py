"""What stood still and is unlabelled, for each kind of sensor."""
