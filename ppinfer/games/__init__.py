"""Cost tables and their equilibria: games of N players, one or many at once.

A profile is one plan for every player, a cell of the grid of plan axes; "is an equilibrium" is a factor of zeros and
ones on that grid. This package knows no robot or file of a study. Compiled kernels are imported when they are first
used.
"""

from ppinfer.games.equilibria import finite_profiles, pure_equilibria, regret, undominated
from ppinfer.games.gambit_reading import read_nfg
from ppinfer.games.gambit_writing import write_nfg
from ppinfer.games.game import Game
from ppinfer.games.logit import LogitBranch, logit_branch, logit_response
from ppinfer.games.mixed import MixedEquilibria, mixed_equilibria
from ppinfer.games.pairwise import PairwiseEquilibria, PairwiseGame, pairwise_equilibria
from ppinfer.games.potentials import Potential, potential

__all__ = [
    "Game",
    "LogitBranch",
    "MixedEquilibria",
    "PairwiseEquilibria",
    "PairwiseGame",
    "Potential",
    "finite_profiles",
    "logit_branch",
    "logit_response",
    "mixed_equilibria",
    "pairwise_equilibria",
    "potential",
    "pure_equilibria",
    "read_nfg",
    "regret",
    "undominated",
    "write_nfg",
]
