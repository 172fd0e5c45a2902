"""Ships that are not linear, identified by the extended Kalman filter."""
