"""Studies that compare ways of labelling: design, sessions, measures and results."""
