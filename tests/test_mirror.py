"""Every module has its tests where they are looked for: in the file of its name.

``tests/psp3`` and ``tests/fuzzy2`` mirror the packages. The table names the modules whose tests
have a file of another name, with that file and the reason.
"""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

TESTS = Path(__file__).resolve().parent
ROOT = TESTS.parent

THROUGH_ITS_FACE = "inner parts, compiled or not, are reached by those that call them"
OF_ALL_SETS = "properties of all sets are tested for all of them at once"
OF_EVERY_COMMAND = "what every command shares is tested on the commands"
OF_THE_JOB = "what it adds to the outcome is read there, since making one takes seconds"
NAMES_ONLY = "has names and numbers only, which are read there"

ELSEWHERE = {
    "fuzzy2/errors.py": (
        "test_public_names.py",
        "each is raised, and its message read, by the tests of what raises it",
    ),
    "fuzzy2/export/c_code.py": ("fuzzy2/export/test_systems.py", THROUGH_ITS_FACE),
    "fuzzy2/export/c_text.py": ("fuzzy2/export/test_function.py", THROUGH_ITS_FACE),
    "fuzzy2/export/calls.py": ("fuzzy2/export/test_expressions.py", THROUGH_ITS_FACE),
    "fuzzy2/export/definitions.py": ("fuzzy2/export/test_arrays.py", THROUGH_ITS_FACE),
    "fuzzy2/export/frame.py": ("fuzzy2/export/test_function.py", THROUGH_ITS_FACE),
    "fuzzy2/export/kernel_source.py": ("fuzzy2/export/test_function.py", THROUGH_ITS_FACE),
    "fuzzy2/export/numbers.py": ("fuzzy2/export/test_arrays.py", THROUGH_ITS_FACE),
    "fuzzy2/export/project_calls.py": ("fuzzy2/export/test_project.py", THROUGH_ITS_FACE),
    "fuzzy2/export/project_cases.py": ("fuzzy2/export/test_project.py", THROUGH_ITS_FACE),
    "fuzzy2/export/project_readme.py": ("fuzzy2/export/test_project.py", THROUGH_ITS_FACE),
    "fuzzy2/export/system_kernels.py": ("fuzzy2/export/test_systems.py", THROUGH_ITS_FACE),
    "fuzzy2/export/values.py": ("fuzzy2/export/test_function.py", THROUGH_ITS_FACE),
    "fuzzy2/files/operator_words.py": ("fuzzy2/files/test_fis_writer.py", THROUGH_ITS_FACE),
    "fuzzy2/files/description.py": ("fuzzy2/files/test_fis.py", THROUGH_ITS_FACE),
    "fuzzy2/files/engine.py": ("fuzzy2/files/test_fll.py", THROUGH_ITS_FACE),
    "fuzzy2/files/engine_writer.py": ("fuzzy2/files/test_fll.py", THROUGH_ITS_FACE),
    "fuzzy2/files/fcl_formula.py": ("fuzzy2/files/test_fcl.py", THROUGH_ITS_FACE),
    "fuzzy2/files/fcl_names.py": ("fuzzy2/files/test_fcl.py", THROUGH_ITS_FACE),
    "fuzzy2/files/fcl_reader.py": ("fuzzy2/files/test_fcl.py", THROUGH_ITS_FACE),
    "fuzzy2/files/fcl_writer.py": ("fuzzy2/files/test_fcl.py", THROUGH_ITS_FACE),
    "fuzzy2/files/fll_names.py": ("fuzzy2/files/test_fll.py", THROUGH_ITS_FACE),
    "fuzzy2/files/fll_reader.py": ("fuzzy2/files/test_fll.py", THROUGH_ITS_FACE),
    "fuzzy2/files/fll_writer.py": ("fuzzy2/files/test_fll.py", THROUGH_ITS_FACE),
    "fuzzy2/files/rule_text.py": ("fuzzy2/files/test_fll.py", THROUGH_ITS_FACE),
    "fuzzy2/files/rule_writer.py": ("fuzzy2/files/test_fll.py", THROUGH_ITS_FACE),
    "fuzzy2/files/clauses.py": ("fuzzy2/files/test_formats.py", THROUGH_ITS_FACE),
    "fuzzy2/files/fis_engine_writer.py": ("fuzzy2/files/test_fis_engine.py", THROUGH_ITS_FACE),
    "fuzzy2/files/functions.py": ("fuzzy2/files/test_fll.py", THROUGH_ITS_FACE),
    "fuzzy2/files/fis_lines.py": ("fuzzy2/files/test_fis_reader.py", THROUGH_ITS_FACE),
    "fuzzy2/files/fis_names.py": ("fuzzy2/files/test_fis_reader.py", THROUGH_ITS_FACE),
    "fuzzy2/files/fis_rules.py": ("fuzzy2/files/test_fis_reader.py", THROUGH_ITS_FACE),
    "fuzzy2/files/fis_shapes.py": ("fuzzy2/files/test_fis_reader.py", THROUGH_ITS_FACE),
    "fuzzy2/files/fml_elements.py": ("fuzzy2/files/test_fml_reader.py", THROUGH_ITS_FACE),
    "fuzzy2/files/fml_names.py": ("fuzzy2/files/test_fml_reader.py", THROUGH_ITS_FACE),
    "fuzzy2/files/fml_rules.py": ("fuzzy2/files/test_fml_reader.py", THROUGH_ITS_FACE),
    "fuzzy2/files/fml_terms.py": ("fuzzy2/files/test_fml_reader.py", THROUGH_ITS_FACE),
    "fuzzy2/files/json_kinds.py": ("fuzzy2/files/test_json_files.py", THROUGH_ITS_FACE),
    "fuzzy2/files/source.py": ("fuzzy2/files/test_fis_reader.py", THROUGH_ITS_FACE),
    "fuzzy2/learning/tuning_kernels.py": (
        "fuzzy2/learning/test_tunable_system.py",
        THROUGH_ITS_FACE,
    ),
    "fuzzy2/learning/adaptation_kernels.py": (
        "fuzzy2/learning/test_adaptation.py",
        THROUGH_ITS_FACE,
    ),
    "fuzzy2/learning/estimator.py": ("fuzzy2/learning/test_wang_mendel.py", THROUGH_ITS_FACE),
    "fuzzy2/learning/samples.py": ("fuzzy2/learning/test_wang_mendel.py", THROUGH_ITS_FACE),
    "fuzzy2/numbers/base.py": ("fuzzy2/numbers/test_affine.py", THROUGH_ITS_FACE),
    "fuzzy2/reduction/kernels.py": ("fuzzy2/reduction/test_interval.py", THROUGH_ITS_FACE),
    "fuzzy2/sets/curves.py": ("fuzzy2/sets/test_type1.py", THROUGH_ITS_FACE),
    "fuzzy2/sets/shapes.py": ("fuzzy2/sets/test_type1.py", OF_ALL_SETS),
    "fuzzy2/support/checks.py": (
        "cross/test_bad_input.py",
        "what is refused is tested where users meet it",
    ),
    "fuzzy2/support/lazy.py": ("test_public_names.py", "tested on every facade of both packages"),
    "fuzzy2/support/quadrature.py": ("fuzzy2/sets/test_interval_type2.py", THROUGH_ITS_FACE),
    "fuzzy2/files/json_rules.py": ("fuzzy2/files/test_json_files.py", THROUGH_ITS_FACE),
    "fuzzy2/systems/explainable.py": ("fuzzy2/systems/test_explanation.py", NAMES_ONLY),
    "fuzzy2/systems/averages.py": ("fuzzy2/systems/test_operators.py", THROUGH_ITS_FACE),
    "fuzzy2/systems/firing_kernels.py": ("fuzzy2/systems/test_antecedents.py", THROUGH_ITS_FACE),
    "fuzzy2/systems/anya_kernels.py": ("fuzzy2/systems/test_anya.py", THROUGH_ITS_FACE),
    "fuzzy2/systems/log_firing_kernels.py": ("fuzzy2/systems/test_log_firing.py", THROUGH_ITS_FACE),
    "fuzzy2/systems/end_slopes.py": ("fuzzy2/systems/test_gradients.py", THROUGH_ITS_FACE),
    "fuzzy2/systems/norm_slopes.py": ("fuzzy2/systems/test_gradients.py", THROUGH_ITS_FACE),
    "fuzzy2/systems/compiled_outputs.py": (
        "fuzzy2/systems/test_output_tables.py",
        THROUGH_ITS_FACE,
    ),
    "fuzzy2/systems/summed.py": ("fuzzy2/systems/test_sampled_rows.py", THROUGH_ITS_FACE),
    "fuzzy2/systems/maxima.py": ("fuzzy2/systems/test_united.py", THROUGH_ITS_FACE),
    "fuzzy2/systems/output_kernels.py": ("fuzzy2/systems/test_operators.py", THROUGH_ITS_FACE),
    "fuzzy2/systems/outputs.py": ("fuzzy2/systems/test_operators.py", THROUGH_ITS_FACE),
    "fuzzy2/systems/rule_grammar.py": ("fuzzy2/systems/test_rules.py", THROUGH_ITS_FACE),
    "fuzzy2/systems/shape_kernels.py": ("fuzzy2/systems/test_term_rows.py", THROUGH_ITS_FACE),
    "fuzzy2/systems/union_rows.py": ("fuzzy2/systems/test_united.py", THROUGH_ITS_FACE),
    "fuzzy2/systems/united_kernels.py": ("fuzzy2/systems/test_united.py", THROUGH_ITS_FACE),
    "fuzzy2/support/version.py": ("fuzzy2/export/test_systems.py", NAMES_ONLY),
    "fuzzy2/systems/corollary_kernels.py": (
        "fuzzy2/systems/test_general_type2.py",
        THROUGH_ITS_FACE,
    ),
    "fuzzy2/support/viewers.py": ("fuzzy2/support/test_shown.py", THROUGH_ITS_FACE),
    "fuzzy2/systems/construction.py": ("fuzzy2/systems/test_system.py", THROUGH_ITS_FACE),
    "fuzzy2/systems/table.py": ("fuzzy2/systems/test_kernels.py", THROUGH_ITS_FACE),
    "psp3/cli/app.py": ("psp3/cli/test_entry.py", OF_EVERY_COMMAND),
    "psp3/cli/commands/reproduce.py": ("psp3/thesis/test_replication.py", OF_THE_JOB),
    "psp3/cli/joint_tables.py": ("psp3/cli/commands/test_pose.py", OF_EVERY_COMMAND),
    "psp3/cli/export_options.py": ("psp3/cli/commands/test_export_fmu.py", OF_EVERY_COMMAND),
    "psp3/cli/option_groups.py": ("psp3/cli/test_entry.py", OF_EVERY_COMMAND),
    "psp3/cli/options.py": ("psp3/cli/test_entry.py", OF_EVERY_COMMAND),
    "psp3/cli/robot_options.py": ("psp3/cli/test_entry.py", OF_EVERY_COMMAND),
    "psp3/cli/shared.py": ("psp3/cli/commands/test_torques.py", OF_EVERY_COMMAND),
    "psp3/export/fmu_controller.py": ("psp3/export/test_fmu.py", THROUGH_ITS_FACE),
    "psp3/export/fmu_description.py": ("psp3/export/test_fmu.py", THROUGH_ITS_FACE),
    "psp3/export/fmu_fmi2.py": ("psp3/export/test_fmu.py", THROUGH_ITS_FACE),
    "psp3/export/fmu_fmi3.py": ("psp3/export/test_fmu.py", THROUGH_ITS_FACE),
    "psp3/export/fmu_standard.py": ("psp3/export/test_fmu.py", THROUGH_ITS_FACE),
    "psp3/export/fmu_glue.py": ("psp3/export/test_fmu.py", THROUGH_ITS_FACE),
    "psp3/export/fmu_kernels.py": ("psp3/export/test_fmu.py", THROUGH_ITS_FACE),
    "psp3/export/fmu_model.py": ("psp3/export/test_fmu.py", THROUGH_ITS_FACE),
    "psp3/export/fmu_names.py": ("psp3/export/test_fmu.py", THROUGH_ITS_FACE),
    "psp3/export/fmu_plant.py": ("psp3/export/test_fmu.py", THROUGH_ITS_FACE),
    "psp3/closure/passive_limits.py": ("psp3/robots/test_closed_loop_robot.py", THROUGH_ITS_FACE),
    "psp3/control/controller.py": (
        "psp3/simulation/test_tracking.py",
        "a protocol; controllers of one's own are simulated there",
    ),
    "psp3/control/kernels.py": ("psp3/simulation/test_loop.py", THROUGH_ITS_FACE),
    "psp3/control/linear_quadratic_kernels.py": (
        "cross/test_simulated_structures.py",
        THROUGH_ITS_FACE,
    ),
    "psp3/export/controller_kernels.py": ("psp3/export/test_controllers.py", THROUGH_ITS_FACE),
    "psp3/export/closed_form_kernels.py": ("psp3/export/test_closed_form.py", THROUGH_ITS_FACE),
    "psp3/export/face.py": ("psp3/export/test_controllers.py", THROUGH_ITS_FACE),
    "psp3/export/robot_kernels.py": ("psp3/export/test_robots.py", THROUGH_ITS_FACE),
    "psp3/export/robot_text.py": ("psp3/export/test_robots.py", THROUGH_ITS_FACE),
    "psp3/description/mjcf_document.py": ("psp3/description/test_mjcf.py", THROUGH_ITS_FACE),
    "psp3/description/mjcf_expansion.py": ("cross/test_mjcf_expansion.py", THROUGH_ITS_FACE),
    "psp3/description/mjcf_words.py": ("cross/test_mutated_mjcf.py", THROUGH_ITS_FACE),
    "psp3/description/mjcf_inertia.py": ("cross/test_mjcf_meshes.py", THROUGH_ITS_FACE),
    "psp3/description/mjcf_tree.py": ("psp3/description/test_mjcf.py", THROUGH_ITS_FACE),
    "psp3/description/parts.py": ("psp3/test_loading.py", NAMES_ONLY),
    "psp3/description/sdf_joints.py": ("psp3/description/test_sdf.py", THROUGH_ITS_FACE),
    "psp3/description/sdf_shapes.py": ("psp3/description/test_sdf.py", THROUGH_ITS_FACE),
    "psp3/description/sdf_tree.py": ("psp3/description/test_sdf.py", THROUGH_ITS_FACE),
    "psp3/description/sdf_unread.py": ("psp3/description/test_sdf.py", THROUGH_ITS_FACE),
    "psp3/dynamics/closed_pose.py": ("psp3/robots/test_closed_loop_robot.py", THROUGH_ITS_FACE),
    "psp3/dynamics/compiled_robot.py": ("psp3/simulation/test_plant.py", THROUGH_ITS_FACE),
    "psp3/dynamics/driven_steps.py": ("psp3/simulation/test_plant.py", THROUGH_ITS_FACE),
    "psp3/dynamics/joined_frames.py": ("psp3/dynamics/test_projected.py", THROUGH_ITS_FACE),
    "psp3/fuzzy_control/adaptive_kernels.py": (
        "psp3/fuzzy_control/test_adaptive.py",
        THROUGH_ITS_FACE,
    ),
    "psp3/fuzzy_control/slotine_li_kernels.py": (
        "psp3/fuzzy_control/test_slotine_li.py",
        THROUGH_ITS_FACE,
    ),
    "psp3/fuzzy_control/kernels.py": (
        "psp3/simulation/test_loop.py",
        "compiled loops that call them are compared with the loop in Python bit for bit",
    ),
    "psp3/kinematics/border.py": ("psp3/kinematics/test_workspace.py", THROUGH_ITS_FACE),
    "psp3/plots/panels.py": ("psp3/thesis/test_figures.py", THROUGH_ITS_FACE),
    "psp3/published.py": ("psp3/thesis/test_replication.py", NAMES_ONLY),
    "psp3/robots/assembly.py": ("psp3/robots/test_closed_loop_robot.py", THROUGH_ITS_FACE),
    "psp3/robots/dynamics_model.py": (
        "psp3/dynamics/test_dynamics_model.py",
        "the first path of the names of a module that moved",
    ),
    "psp3/simulation/dormand_prince.py": (
        "psp3/simulation/test_plant.py",
        "plants are compared with one another",
    ),
    "psp3/simulation/kernels.py": ("psp3/simulation/test_loop.py", THROUGH_ITS_FACE),
    "psp3/thesis/chapter_5.py": ("psp3/thesis/test_replication.py", OF_THE_JOB),
    "psp3/thesis/illustrations.py": ("psp3/thesis/test_replication.py", OF_THE_JOB),
    "psp3/three_psp/stepping.py": ("psp3/simulation/test_plant.py", THROUGH_ITS_FACE),
    "psp3/version.py": ("psp3/cli/test_entry.py", NAMES_ONLY),
    "psp3/visualize/shapes.py": ("psp3/visualize/test_robot_visualizer.py", THROUGH_ITS_FACE),
    "psp3/warm_up.py": (
        "test_notebooks.py",
        "it is called in every server that forks processes for the tests",
    ),
}


def modules() -> list[str]:
    """Return the modules of both packages; of facades those that do more than look up names."""
    files = [path for name in ("psp3", "fuzzy2") for path in sorted((ROOT / name).rglob("*.py"))]
    return [
        path.relative_to(ROOT).as_posix()
        for path in files
        if path.name != "__init__.py" or path.parent.parent == ROOT or defines_names(path)
    ]


def defines_names(path: Path) -> bool:
    """Return whether a module has functions or classes of its own."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return any(isinstance(node, ast.FunctionDef | ast.ClassDef) for node in tree.body)


def file_of(module: str) -> str:
    """Return where a module's tests are looked for."""
    folder, _, name = module.rpartition("/")
    stem = "facade" if name == "__init__.py" else name.removesuffix(".py")
    return f"{folder}/test_{stem}.py"


MODULES = modules()
FILES = [
    path.relative_to(TESTS).as_posix()
    for package in ("psp3", "fuzzy2")
    for path in sorted((TESTS / package).rglob("test_*.py"))
]


@pytest.mark.parametrize("module", MODULES)
def test_every_module_has_a_file_of_tests_or_says_where_they_are(module: str) -> None:
    if (TESTS / file_of(module)).exists():
        assert module not in ELSEWHERE, "it has a file of its own"
    else:
        assert module in ELSEWHERE, f"tests/{file_of(module)} is missing"


@pytest.mark.parametrize("file", FILES)
def test_every_file_of_tests_is_that_of_a_module(file: str) -> None:
    assert file in map(file_of, MODULES)


@pytest.mark.parametrize("module", ELSEWHERE)
def test_modules_and_files_of_the_table_are_there(module: str) -> None:
    file, reason = ELSEWHERE[module]
    assert module in MODULES
    assert (TESTS / file).exists()
    assert reason
