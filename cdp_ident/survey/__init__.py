"""Many bags of many rigs: identified piece by piece, by several processes or machines, and looked at together."""
