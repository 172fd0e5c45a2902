"""The trainer beside others: C, JSBSim, scipy, statsmodels, node, and the machine of 1969."""
