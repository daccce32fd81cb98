"""Classes of equilibria by whom they favour: theta, and what it makes of a profile."""

from ppinfer.coordination.classes.favouring import FAIR, FavourBy, favoured_classes
from ppinfer.coordination.classes.weighing import log_class_likelihood, log_p_alpha

__all__ = ["FAIR", "FavourBy", "favoured_classes", "log_class_likelihood", "log_p_alpha"]
