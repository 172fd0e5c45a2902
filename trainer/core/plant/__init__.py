"""The plant: what feeds surfaces, pumps, gauges and propulsion, and what takes it away."""
