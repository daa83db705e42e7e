//! Local maxima of any field on any points, and the rules that pick contacts among them.
