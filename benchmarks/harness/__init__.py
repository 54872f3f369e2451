"""How the benchmarks measure: peers in their own processes, rounds in turn, tables."""
