"""Public names: those that users have stay, and none of a facade's is one of its modules, too."""

from __future__ import annotations

import importlib
import pkgutil
from types import ModuleType

import pytest

import fuzzy2
import psp3

PUBLIC = {
    "psp3": """
        PARAMETER_SETS PD PID PSP3 AdaptiveFuzzyComputedTorque ClosedLoopRobot ComputedTorque \
ConformalIntervals TrackingTube \
Drive FeedForward FuzzyComputedTorque
        GravityCompensatedPD LinearQuadraticRegulator Monitor MuJoCo NaturalOrthogonalComplement \
PSP3Error Parameters Pose Result Run
        SingularityAnalysis Study TaskSpaceComputedTorque TimeVaryingLinearQuadraticRegulator \
Workspace exciting_motion export_c export_fmu
        forward_dynamics_derivatives grid identify inverse_dynamics_derivatives linearize load \
load_result simulate statistics to_mjcf
        symbolic trajectories with_payload
    """,
    "fuzzy2": """
        ANFIS AnYaSystem FuzzyClassifier automf lagged subtractive_clustering view
        AdaptiveConsequents ApproximationWarning Bell Clusters Complement FineTuning FunctionalSet \
FunctionalType2Set Fuzzy2Error NamedShape ParallelSystem
        FuzzyNumber FuzzySystem Gaussian GaussianNumber GaussianType2Set GaussianUncertainMean \
GaussianUncertainSigma GeneralType2Set
        GeneralType2System Interval IntervalNumber IntervalType2Set IntervalType2System Linear \
NonSingletonFuzzifier PiShaped Rule
        SampledSet SampledType2Set Sigmoid SigmoidDifference SigmoidProduct Singleton \
SingletonFuzzifier Trapezoidal Triangular
        TwoSidedGaussian Type1Set Type1System WangMendel ZSlices add_noise alpha_plane_centroid \
alpha_plane_reduction
        approximate_centroid approximate_generalized_centroid begian_melek_mendel cardinality \
cartesian_product centroid complement
        compose defuzzify export_c exhaustive_centroid exhaustive_generalized_centroid extend \
fine_tune format_rules from_json fuzziness
        fuzzy_c_means gaussian_meet gaussian_meet_error gaussian_partition generalized_centroid \
intersection jaccard join load
        mean_variation_from_snr meet negation nie_tan parse_rules rank save \
snr_from_mean_variation t_conorm t_norm to_json union
        wu_mendel_bounds
    """,
    "psp3.trajectories": """
        SPACES Circle FromCSV Helix Hold Line MeasuredMotion Motion PointToPoint Sway Trajectory \
Waypoints check_stroke finite_times measured_motion tip_of
    """,
    "psp3.study.statistics": """
        CONFIDENCE CONTROLLERS MEASURED_COVERAGE METRICS RESAMPLES Contrast Estimate Summary \
compare mean median paired_difference ratio_of_geometric_means ratio_of_means share
        summarize
    """,
    "psp3.visualize": "Scene Viewer write_animation",
    "psp3.errors": """
        ClosureFailed CollisionFound CorrelatedResiduals DisorderedJoints InconsistentVelocity \
InvalidArray InvalidControllerFile InvalidFile InvalidMapFile
        InvalidResultFile InvalidRobotFile InvalidStudyFile InvalidTorque InvalidTrajectoryFile \
InvalidValue JointLimitExceeded
        MasslessBody MissingPackage MobilityMismatch MotionDiverged NoFiniteAnswer \
NoStabilizingSolution NoThreshold NotTrained OpenLoops
        OverlappingShapes PSP3Error PoorExcitation RunsFailed SchedulerUnavailable \
SimulationDiverged SimulationStopped
        SourceOnlyFMU
        SingularConfiguration StrokeExceeded StudyFileNotWritable StudyInUse StudyInterrupted \
StudyMismatch UncertainRank
        UnexportableJoint UnknownName UnknownRobot UnphysicalInertia UnreachablePose \
UnreachableTip UnsupportedJoint UnusableEstimate
    """,
    "fuzzy2.errors": """
        CompletedRules \
        ApproximationWarning FeatureNamesWarning Fuzzy2Error InvalidRule InvalidValue \
FileInTheWay MalformedFile NotApplicable NotExportable NotExpressible RaisedOnPurpose
        NotFitted NotNumbers TooManyEmbeddedSets UnknownName UnsupportedRule WrongFeatures
    """,
    "fuzzy2.plots": """
        ACROSS POINTS REACH VISIBLE figure_1 figure_2 figure_3 figure_4 figure_5 figure_from_above \
figure_in_space
        figure_of_join_and_meet figure_of_operations figure_of_response figure_of_rule_surface \
figure_of_secondaries figure_of_sets
        figure_of_type_reduced
    """,
    "psp3.bounds": """
        ConformalIntervals ErrorDynamics TrackingTube conformal_bound residual_accelerations \
runs_needed
    """,
    # Packages that took the name of a module.
    "psp3.closure": "ASSEMBLED CLOSURE_TOLERANCE NO_MOTORS assembled flattened residual",
    "psp3.collisions": "Contact Report check check_clearance",
    "psp3.drives": "NO_DRIVE Drive drive_table",
    "psp3.identification": "CONFIDENCE Identified identify",
    "psp3.simulation": "Encoder Result load_result simulate",
    "psp3.symbolic": "SymbolicPSP3 SymbolicRobot fuzzy_torque",
    "psp3.study": "Grid Progress Study Table grid",
    "fuzzy2.learning": (
        "COMPLETIONS KINDS LEARNERS PARTITIONS WangMendel cluster_partition gaussian_partition "
        "term_names"
    ),
    "fuzzy2.numbers": "FuzzyNumber GaussianNumber IntervalNumber gaussian_meet gaussian_meet_error",
    "fuzzy2.systems": (
        "AnySet FuzzySystem GeneralType2System IntervalType2System Linear Report Type1System"
    ),
}
ROOTS = (psp3, fuzzy2)
PACKAGES = [
    importlib.import_module(name)
    for root in ROOTS
    for name in [
        root.__name__,
        *(
            found.name
            for found in pkgutil.walk_packages(root.__path__, f"{root.__name__}.")
            if found.ispkg
        ),
    ]
]
FACADES = [package for package in PACKAGES if hasattr(package, "__all__")]


@pytest.mark.parametrize(
    ("module", "name"),
    [(module, name) for module, names in PUBLIC.items() for name in names.split()],
)
def test_a_public_name_stays(module: str, name: str) -> None:
    assert getattr(importlib.import_module(module), name) is not None


@pytest.mark.parametrize("root", ROOTS, ids=lambda root: root.__name__)
def test_a_root_offers_no_more_than_is_pinned(root: ModuleType) -> None:
    """A new public name is a promise: it is written here, too."""
    assert sorted(root.__all__) == sorted(PUBLIC[root.__name__].split())


def test_names_that_are_modules_are_those_of_the_root() -> None:
    assert psp3.statistics is importlib.import_module("psp3.study.statistics")
    assert psp3.trajectories is importlib.import_module("psp3.trajectories")


@pytest.mark.parametrize("facade", FACADES, ids=lambda facade: facade.__name__)
def test_no_facade_offers_a_name_that_one_of_its_modules_bears(facade: ModuleType) -> None:
    """It would be the module or the thing, depending on who imported first.

    A module that is offered as such is one and the same.
    """
    modules = {found.name for found in pkgutil.iter_modules(facade.__path__)}
    for name in modules & set(facade.__all__):
        assert getattr(facade, name) is importlib.import_module(f"{facade.__name__}.{name}")


@pytest.mark.parametrize("facade", FACADES, ids=lambda facade: facade.__name__)
def test_a_facade_lists_what_it_offers_and_knows_nothing_else(facade: ModuleType) -> None:
    assert dir(facade) == sorted(facade.__all__)
    for name in facade.__all__:
        assert getattr(facade, name) is not None
    with pytest.raises(
        AttributeError, match=f"'{facade.__name__}' has no attribute 'none_of_these'"
    ):
        _ = facade.none_of_these
