"""ppsim: small worlds whose agents' goals are known, which feed observations to ppinfer."""
