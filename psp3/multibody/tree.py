r"""A tree with loops as flat arrays: the arguments of the kernels of :mod:`psp3.multibody`.

The tree consists of *elements*. A joint of one degree of freedom is an element with a constant
screw :math:`S` and the placement :math:`M_0 \exp(S q)`. Ball joints, planar joints and free flyers
are elements of other kinds. A *group* is a set of closures that share dependent joints. Groups do
not depend on each other, so the cost is proportional to their number, not to its cube.

The whole numbers of a tree are in one array, ``tree``; its other numbers are in a second,
``numbers``; and values that change are in a third, ``memory``. Passing more arguments would take
longer than some of these kernels, and the exported C code can use the same arrays. The first
entries of ``tree`` are counts, followed by the places where the parts begin (their names begin with
``AT``). For example, entry ``tree[AT_SCREWS] + 6 v`` of the memory is the first of the screw of
velocity v.
"""

from __future__ import annotations

SCREW, UNBOUNDED, BALL, FREE, PLANAR = range(5)
"""Kinds of elements: one degree of freedom in one coordinate; an angle as cosine and sine; a
quaternion; position and quaternion; position in a plane, and the cosine and sine of an angle.
"""

POINT, HINGE, FRAME, COUPLING, SPIN = range(5)
"""Kinds of closures: two frames share their origin; two frames share origin and z axis; two frames
coincide; a coordinate is a polynomial of another; a ball joint does not rotate about an axis of its
body.
"""

ROWS_OF_KIND = (3, 5, 6, 1, 1)
"""Equations of each kind of closure."""

COUNTS = 16
(
    ELEMENTS,
    BODIES,
    CLOSURES,
    GROUPS,
    MEMBERS,
    PATHS,
    DRIVERS,
    COORDINATES,
    VELOCITIES,
    INDEPENDENT,
    DEPENDENT,
    ROWS,
    FACTORS,
    DRIVEN,
    POSITIONS,
    FLOATING,
) = range(COUNTS)
"""The counts. The last five are: closure equations; entries of all groups' Jacobians with respect
to dependent speeds; the same for independent speeds; coordinates of the independent joints, which
are more than their speeds if one of them is a free flyer; and, not a count, the element of a
floating base, or −1.
"""

INTEGER_PARTS = 12
(
    AT_ELEMENTS,
    AT_MASSIVE,
    AT_CLOSURES,
    AT_GROUPS,
    AT_MEMBERS,
    AT_PATHS,
    AT_DRIVERS,
    AT_COLUMN_OF,
    AT_INDEPENDENT_Q,
    AT_INDEPENDENT_V,
    AT_DEPENDENT_V,
    AT_ENDS,
) = range(COUNTS, COUNTS + INTEGER_PARTS)
"""Where the parts of the whole numbers begin.

Elements, closures, groups (with an additional last row, which holds the ends) and paths are rows,
see below. ``AT_MASSIVE`` lists the elements that have mass or inertia. Members are the elements of
each group, parents first, followed by the list of all elements. Drivers are the places of the
groups' independent speeds among all independent speeds. A velocity's column is its place among the
dependent speeds, or −1 − its place among the independent ones, or ``LOCKED``. The remaining parts
are: the coordinates of the independent joints; the velocity index of each independent speed (joints
of one degree of freedom come first, so that coordinates and speeds have the same places); the
velocity index of each dependent speed; and the row below the last entry of its column in the
factored Jacobian.
"""

NUMBER_PARTS = 7
(
    AT_BODIES,
    AT_CLOSURE_FRAMES,
    AT_TOLERANCES,
    AT_JOINTS,
    AT_RESTS,
    AT_LIMITS,
    AT_FREE_FALL,
) = range(COUNTS + INTEGER_PARTS, COUNTS + INTEGER_PARTS + NUMBER_PARTS)
"""Where the parts of the other numbers begin: rows of elements, closures, groups and velocities,
see below; for each coordinate, the rest of its spring and its lowest and highest value; and the
acceleration of free fall (3) [m/s²].
"""

MEMORY_PARTS = 43
(
    AT_CONFIGURATION,
    AT_HERE,
    AT_PLACEMENTS,
    AT_SCREWS,
    AT_FRAMES,
    AT_FACTORS,
    AT_REFLECTIONS,
    AT_DRIVEN,
    AT_SIGNS,
    AT_BEFORE,
    AT_BEFORE_REFLECTIONS,
    AT_CLOSED,
    AT_ORIGIN,
    AT_TARGET,
    AT_RESIDUAL,
    AT_RIGHT,
    AT_SPEED,
    AT_MOVED,
    AT_TURN,
    AT_ACROSS,
    AT_JOINT_SPEEDS,
    AT_JOINT_ACCELERATIONS,
    AT_JOINT_FORCES,
    AT_INERTIAS,
    AT_VELOCITIES,
    AT_ACCELERATIONS,
    AT_FORCES,
    AT_FIELDS,
    AT_RATES,
    AT_COMPLEMENT,
    AT_COMPLEMENT_RATES,
    AT_MASS,
    AT_ROOM,
    AT_REPORT,
    AT_SECOND_RATES,
    AT_FIELD_FORCES,
    AT_SPINS,
    AT_LOADS,
    AT_LOOP_FORCES,
    AT_JOINT_LOADS,
    AT_BY_POSITIONS,
    AT_BY_SPEEDS,
    AT_VECTORS,
) = range(
    COUNTS + INTEGER_PARTS + NUMBER_PARTS, COUNTS + INTEGER_PARTS + NUMBER_PARTS + MEMORY_PARTS
)
"""Where the parts of the memory begin. The parts before ``BEFORE`` describe a *pose* completely,
and can be copied as a whole:

configuration; position of the floating base (3), or zeros; placements of the elements in the base's
axes, relative to that position (12: rotation, row by row, and position), so that no digits are lost
if it is far away; screws of the velocities (6: linear part at that position, and angular part); the
two frames of each closure, relative to that position (24); Jacobians of the groups with respect to
their dependent speeds, factored, column by column, with the weights of the reflections; Jacobians
with respect to their independent speeds; and each group's smallest pivot, with the sign of its
determinant.

Then follow: factors, weights and configuration of the pose from which the search for the next one
starts; start and target of a motion in independent coordinates; residual; right side of a group's
equations, later their solution; speeds of the dependent joints along the way, and how far Newton's
method moved them; derivative of a rotation vector with respect to the angular velocity (9); a
square matrix of the dependent speeds of a group; velocities, accelerations and forces of all
joints; inertias of the elements (10); twists of the elements (6), the base last, their
accelerations and forces; the same twists and accelerations for every independent speed; L, column
by column, and its rate of change; a square matrix of the independent speeds; room for eight vectors
of that size; and the report on a closure (4): the share of the way, the residual, the group, and
the outcome.

The last parts are for derivatives: second rates of the twists of one column, and the corresponding
wrenches of the elements; the effect of rotation on the momenta of each body (12); the wrench on all
that each element carries; the force in each closure (6); changes of the joints' own forces; the
derivatives by positions and by speeds, column by column; and room for seven twists.
"""

SIZE = COUNTS + INTEGER_PARTS + NUMBER_PARTS + MEMORY_PARTS
"""The entry that holds the size of the memory."""
HEADER = SIZE + 1

ELEMENT_INTEGERS = 5
KIND, PARENT, INDEX_Q, INDEX_V, FREEDOMS = range(ELEMENT_INTEGERS)
"""For each element: kind; parent element, or −1; places of its first coordinate and of its first
velocity; degrees of freedom.
"""

ELEMENT_NUMBERS = 28
SCREW_AT, MASS_AT, CENTER_AT, INERTIA_AT = 12, 18, 19, 22
"""For each element: rotation, row by row, and position of its joint in its parent (12); linear and
angular part of its screw (6); mass, center of mass (3), and inertia about the center of mass (xx,
xy, xz, yy, yz, zz), in its own axes [kg, m, kg m²].
"""

CLOSURE_INTEGERS = 5
CLOSURE_KIND, FIRST_END, SECOND_END, FIRST_ROW, COUPLED_SPEED = range(CLOSURE_INTEGERS)
"""For each closure: kind, the two elements that it joins (−1 is the base), and its first equation
among those of its group. A coupling has the coordinates y and x instead of elements, and the
velocity of x at the end. A spin has the first coordinate of its ball joint, and the ball's first
velocity at the end.
"""

CLOSURE_NUMBERS = 24
LARGEST_DEGREE = 4
"""For each closure: the placements of its two frames in their elements. A coupling has the
coefficients of its polynomial instead, the constant first. A spin has its axis (3) and the
quaternion at which it is zero.
"""

GROUP_INTEGERS = 12
(
    FIRST_MEMBER,
    FIRST_CLOSURE,
    FIRST_PATH,
    FIRST_DRIVER,
    GROUP_ROW,
    GROUP_COLUMN,
    GROUP_ROWS,
    GROUP_COLUMNS,
    GROUP_DRIVERS,
    FACTOR_AT,
    DRIVEN_AT,
    IS_SQUARE,
) = range(GROUP_INTEGERS)
"""For each group: its first element among the members, first closure, first step of a path and
first driver (those of the next group are the ends); its first equation and first dependent speed;
the numbers of its equations, dependent speeds and independent speeds; where its Jacobians begin;
whether it has as many equations as dependent speeds.
"""

PATH_INTEGERS = 5
PATH_CLOSURE, PATH_VELOCITY, PATH_SIGN, PATH_COLUMN, PATH_ELEMENT = range(PATH_INTEGERS)
"""For each velocity that opens a closure: the closure; the velocity; +1 if it moves the second
frame, −1 if it moves the first; its column among the group's dependent speeds, or −1 − its place
among the group's independent ones; its element.
"""

LOCKED = -1_000_000
"""The column of a velocity that is held at zero."""

GROUP_NUMBERS = 5
MISMATCH_AT, WEAKEST_AT = 3, 4
"""For each group: the largest residual of a closed group [m, rad]; the residual or joint step at
which Newton's method has converged [m, rad]; the pivot below which a pose counts as near a singular
one; the residual that is allowed if rounded equations contradict each other; and the pivot up to
which a pose counts as singular.
"""

JOINT_NUMBERS = 4
ARMATURE, DAMPING, STIFFNESS, FRICTION = range(JOINT_NUMBERS)
"""For each velocity: inertia of the motor at this joint [kg or kg m²], viscous damping, stiffness
of its spring (its rest is with the coordinates), and dry friction.
"""
