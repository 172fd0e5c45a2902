"""The worth of a fit: residuals, uncertainty, other models and other records."""
