// One violation: a folder that has no place.
