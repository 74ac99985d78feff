"""Type-1, interval and general type-2 fuzzy logic.

It covers sets, operations, measures, fuzzy numbers, type reduction, systems, learning, files and
plots.

Names are imported at their first use, so ``import fuzzy2`` costs little more than ``import numpy``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fuzzy2.support.lazy import lazy_names
from fuzzy2.support.version import __version__ as __version__
from fuzzy2.support.viewers import viewed_by

if TYPE_CHECKING:
    from fuzzy2.errors import ApproximationWarning as ApproximationWarning
    from fuzzy2.errors import Fuzzy2Error as Fuzzy2Error
    from fuzzy2.export.systems import export_c as export_c
    from fuzzy2.files.formats import load as load
    from fuzzy2.files.formats import save as save
    from fuzzy2.files.json_files import from_json as from_json
    from fuzzy2.files.json_files import to_json as to_json
    from fuzzy2.learning.adaptation import AdaptiveConsequents as AdaptiveConsequents
    from fuzzy2.learning.anfis import ANFIS as ANFIS
    from fuzzy2.learning.automf import automf as automf
    from fuzzy2.learning.classifier import FuzzyClassifier as FuzzyClassifier
    from fuzzy2.learning.clustering import Clusters as Clusters
    from fuzzy2.learning.clustering import fuzzy_c_means as fuzzy_c_means
    from fuzzy2.learning.fine_tuning import FineTuning as FineTuning
    from fuzzy2.learning.fine_tuning import fine_tune as fine_tune
    from fuzzy2.learning.noise import add_noise as add_noise
    from fuzzy2.learning.noise import mean_variation_from_snr as mean_variation_from_snr
    from fuzzy2.learning.noise import snr_from_mean_variation as snr_from_mean_variation
    from fuzzy2.learning.partition import gaussian_partition as gaussian_partition
    from fuzzy2.learning.subtractive import subtractive_clustering as subtractive_clustering
    from fuzzy2.learning.time_series import lagged as lagged
    from fuzzy2.learning.wang_mendel import WangMendel as WangMendel
    from fuzzy2.numbers.affine import GaussianNumber as GaussianNumber
    from fuzzy2.numbers.affine import IntervalNumber as IntervalNumber
    from fuzzy2.numbers.fuzzy_number import FuzzyNumber as FuzzyNumber
    from fuzzy2.numbers.meets import gaussian_meet as gaussian_meet
    from fuzzy2.numbers.meets import gaussian_meet_error as gaussian_meet_error
    from fuzzy2.operations.extension import extend as extend
    from fuzzy2.operations.join_meet import join as join
    from fuzzy2.operations.join_meet import meet as meet
    from fuzzy2.operations.join_meet import negation as negation
    from fuzzy2.operations.measures import cardinality as cardinality
    from fuzzy2.operations.measures import fuzziness as fuzziness
    from fuzzy2.operations.measures import jaccard as jaccard
    from fuzzy2.operations.measures import rank as rank
    from fuzzy2.operations.relations import cartesian_product as cartesian_product
    from fuzzy2.operations.relations import compose as compose
    from fuzzy2.operations.set_operations import complement as complement
    from fuzzy2.operations.set_operations import intersection as intersection
    from fuzzy2.operations.set_operations import union as union
    from fuzzy2.operations.t_norms import t_conorm as t_conorm
    from fuzzy2.operations.t_norms import t_norm as t_norm
    from fuzzy2.plots.viewing import view as view
    from fuzzy2.reduction.approximate import approximate_centroid as approximate_centroid
    from fuzzy2.reduction.approximate import (
        approximate_generalized_centroid as approximate_generalized_centroid,
    )
    from fuzzy2.reduction.defuzzification import defuzzify as defuzzify
    from fuzzy2.reduction.general import alpha_plane_centroid as alpha_plane_centroid
    from fuzzy2.reduction.general import alpha_plane_reduction as alpha_plane_reduction
    from fuzzy2.reduction.general import exhaustive_centroid as exhaustive_centroid
    from fuzzy2.reduction.general import (
        exhaustive_generalized_centroid as exhaustive_generalized_centroid,
    )
    from fuzzy2.reduction.interval import begian_melek_mendel as begian_melek_mendel
    from fuzzy2.reduction.interval import centroid as centroid
    from fuzzy2.reduction.interval import generalized_centroid as generalized_centroid
    from fuzzy2.reduction.interval import nie_tan as nie_tan
    from fuzzy2.reduction.interval import wu_mendel_bounds as wu_mendel_bounds
    from fuzzy2.sets.derived import Complement as Complement
    from fuzzy2.sets.derived import FunctionalSet as FunctionalSet
    from fuzzy2.sets.functional_type2 import FunctionalType2Set as FunctionalType2Set
    from fuzzy2.sets.gaussian_type2 import GaussianType2Set as GaussianType2Set
    from fuzzy2.sets.general_type2 import GeneralType2Set as GeneralType2Set
    from fuzzy2.sets.general_type2 import SampledType2Set as SampledType2Set
    from fuzzy2.sets.general_type2 import ZSlices as ZSlices
    from fuzzy2.sets.interval_type2 import GaussianUncertainMean as GaussianUncertainMean
    from fuzzy2.sets.interval_type2 import GaussianUncertainSigma as GaussianUncertainSigma
    from fuzzy2.sets.interval_type2 import IntervalType2Set as IntervalType2Set
    from fuzzy2.sets.named_shape import NamedShape as NamedShape
    from fuzzy2.sets.shapes import Gaussian as Gaussian
    from fuzzy2.sets.shapes import Interval as Interval
    from fuzzy2.sets.shapes import Trapezoidal as Trapezoidal
    from fuzzy2.sets.shapes import Triangular as Triangular
    from fuzzy2.sets.sigmoids import Sigmoid as Sigmoid
    from fuzzy2.sets.sigmoids import SigmoidDifference as SigmoidDifference
    from fuzzy2.sets.sigmoids import SigmoidProduct as SigmoidProduct
    from fuzzy2.sets.smooth_shapes import Bell as Bell
    from fuzzy2.sets.smooth_shapes import PiShaped as PiShaped
    from fuzzy2.sets.smooth_shapes import TwoSidedGaussian as TwoSidedGaussian
    from fuzzy2.sets.type1 import SampledSet as SampledSet
    from fuzzy2.sets.type1 import Singleton as Singleton
    from fuzzy2.sets.type1 import Type1Set as Type1Set
    from fuzzy2.systems.anya import AnYaSystem as AnYaSystem
    from fuzzy2.systems.consequents import Linear as Linear
    from fuzzy2.systems.fuzzifiers import NonSingletonFuzzifier as NonSingletonFuzzifier
    from fuzzy2.systems.fuzzifiers import SingletonFuzzifier as SingletonFuzzifier
    from fuzzy2.systems.general_type2 import GeneralType2System as GeneralType2System
    from fuzzy2.systems.parallel import ParallelSystem as ParallelSystem
    from fuzzy2.systems.rules import Rule as Rule
    from fuzzy2.systems.rules import format_rules as format_rules
    from fuzzy2.systems.rules import parse_rules as parse_rules
    from fuzzy2.systems.system import FuzzySystem as FuzzySystem
    from fuzzy2.systems.system import IntervalType2System as IntervalType2System
    from fuzzy2.systems.system import Type1System as Type1System


__all__, __getattr__, __dir__ = lazy_names(__name__)

viewed_by(lambda *given: __getattr__("view")(*given))
