//! Frames, geodesy and time-tagged trajectories, with readers for the formats they come in.
