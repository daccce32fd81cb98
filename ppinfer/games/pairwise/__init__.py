"""Games of many players in which only pairs collide: equilibria without the table of all profiles."""

from ppinfer.games.pairwise.found import PairwiseEquilibria
from ppinfer.games.pairwise.game import PairwiseGame
from ppinfer.games.pairwise.search import pairwise_equilibria

__all__ = ["PairwiseEquilibria", "PairwiseGame", "pairwise_equilibria"]
