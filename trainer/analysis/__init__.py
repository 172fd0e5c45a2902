"""The engineer's programs: 1969's, manoeuvres, the guide, reduction, sweeps, debriefs."""
