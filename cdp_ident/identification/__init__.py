"""From trials to parameters: the genetic search and the refinement of its result."""
