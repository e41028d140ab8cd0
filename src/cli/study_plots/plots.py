"""The functions of all plots."""

from .files import Unusable, read_study, study_of
from .over_step import *
from .over_time import *
from .over_variants import *
from .sheet import PLOTS
