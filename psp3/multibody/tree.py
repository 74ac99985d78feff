r"""A tree with loops as flat arrays: what the compiled kernels of :mod:`psp3.multibody` take.

The tree comes as *elements*: joints of one degree of freedom are constant screws :math:`S`, of
placement :math:`M_0 \exp(S q)`; ball joints and free flyers are elements of their own. A *group* is
a set of closures that share joints which are not independent; groups do not depend on one another,
so the cost grows with their number and not with its cube.

The whole numbers of a tree are in one array, ``tree``, its other numbers in a second, ``numbers``,
and what comes and goes in a third, ``memory``. More arguments would cost a call more than some of
these kernels take, and C knows such arrays, too. The first entries of ``tree`` count what there is,
and say where each part begins (their names begin with ``AT``): so entry ``tree[AT_SCREWS] + 6 v``
of the memory is the first of the screw of velocity v.
"""

from __future__ import annotations

SCREW, UNBOUNDED, BALL, FREE, PLANAR = range(5)
"""Kinds of elements: one degree of freedom in one coordinate; an angle as cosine and sine; a
quaternion; position and quaternion; position in a plane, and the cosine and sine of an angle.
"""

POINT, HINGE, FRAME, COUPLING, SPIN = range(5)
"""Kinds of closures: two frames share their origin; also their z axes; they coincide; a coordinate
is a polynomial of another; a ball does not turn about an axis of what it carries.
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
"""How many there are; the last five are closure equations, entries of all groups' Jacobians by
dependent and by independent speeds, coordinates of the independent joints, which are more than
their speeds where one of them is a free flyer, and, which is no count, the element of a floating
base, or −1.
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

Elements, closures, groups (one more than there are: the last holds the ends) and paths are rows,
see below; massive are the numbers of the elements that are bodies, with mass or inertia. Members
are the elements of each group, parents first, and after the last group all of them. Drivers are the
places of the groups' independent speeds among all of them. A velocity's column is its place among
the dependent speeds, or −1 − its place among the independent ones, or ``LOCKED``. The others are
the coordinates of the independent joints, the velocity of each independent speed (joints of one
degree of freedom come first, so that both have the same places), the velocity of each dependent
one, and the row below the last entry of its column when that is factored.
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
see below; of each coordinate the rest of its spring, and its lowest and highest value; and the
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
"""Where the parts of the memory begin. What stands before ``BEFORE`` is a *pose*, with all that
stays true of it, and can be copied as a whole:

configuration; where the floating base is (3), or zeros; placements of the elements in the base's
axes, seen from there (12: rotation, row by row, and position), so that no digits are lost however
far it is; screws of the velocities (6: linear part at that point, and angular part); the two frames
of each closure, seen from there (24); Jacobians of the groups by their dependent speeds, factored,
column by column, with the weights of the reflections; by their independent speeds; and each group's
smallest pivot, with the sign of its determinant.

Then factors, weights and configuration of the pose from which the next is looked for; independent
coordinates from which and to which a motion goes; residual; right side of a group's equations, then
their solution; speeds of the dependent joints along the way, and how far Newton's method moved
them; how a rotation vector changes with the angular velocity (9); a square matrix of the dependent
speeds of a group; velocities, accelerations and forces of all joints; inertias of the elements
(10); twists of the elements (6), the base last, what these accelerate, and the elements' forces;
the same twists and accelerations for every independent speed; L, column by column, and how it
changes; a square matrix of the independent speeds; room for eight vectors of these; and what became
of a closure (4): the share of the way, the residual, the group, and the outcome.

Last, for derivatives: second rates of the twists of one column,
and wrenches of the elements that belong to it; what turning does to the momenta of each body (12);
the wrenches on all that the elements carry; the force in each closure (6); what changes of the
joints' own forces; the derivatives by positions and by speeds, column by column; and room for seven
twists.
"""

SIZE = COUNTS + INTEGER_PARTS + NUMBER_PARTS + MEMORY_PARTS
"""Where the size of the memory stands."""
HEADER = SIZE + 1

ELEMENT_INTEGERS = 5
KIND, PARENT, INDEX_Q, INDEX_V, FREEDOMS = range(ELEMENT_INTEGERS)
"""Of each element: kind; the element that carries it, or −1; place of its first coordinate and
of its first velocity; degrees of freedom.
"""

ELEMENT_NUMBERS = 28
SCREW_AT, MASS_AT, CENTER_AT, INERTIA_AT = 12, 18, 19, 22
"""Of each element: rotation, row by row, and position of its joint in its parent (12); linear and
angular part of its screw (6); mass, center of mass (3), and inertia about that (xx, xy, xz, yy, yz,
zz), in its own axes [kg, m, kg m²].
"""

CLOSURE_INTEGERS = 5
CLOSURE_KIND, FIRST_END, SECOND_END, FIRST_ROW, COUPLED_SPEED = range(CLOSURE_INTEGERS)
"""Of each closure: kind, the two elements that it joins (−1 is the base), and its first equation
among those of its group. A coupling names the coordinates y and x instead of elements, and last the
velocity of x; a spin the first coordinate of its ball, and last its first velocity.
"""

CLOSURE_NUMBERS = 24
LARGEST_DEGREE = 4
"""Of each closure: the placements of its two frames in their elements. A coupling has the
coefficients of its polynomial instead, the constant first; a spin its axis (3) and the quaternion
at which it is zero.
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
"""Of each group: its first element among the members, first closure, first step of a path and
first driver (the next group's are the ends); its first equation and first dependent speed; how many
equations, dependent speeds and independent ones it has; where its Jacobians begin; whether it has
as many equations as dependent speeds.
"""

PATH_INTEGERS = 5
PATH_CLOSURE, PATH_VELOCITY, PATH_SIGN, PATH_COLUMN, PATH_ELEMENT = range(PATH_INTEGERS)
"""Of each velocity that opens a closure: the closure; the velocity; +1 if it moves the second
frame, −1 the first; its column among the group's dependent speeds, or −1 − its place among the
group's independent ones; its element.
"""

LOCKED = -1_000_000
"""In place of a column: a velocity that is held at zero."""

GROUP_NUMBERS = 5
MISMATCH_AT, WEAKEST_AT = 3, 4
"""Of each group: the largest residual of a closed group [m, rad], the residual or step of a joint
at which Newton's method has arrived [m, rad], the smallest pivot below which a pose counts as near
a singular one, the residual that may be left where equations contradict each other by rounding, and
the pivot up to which a pose counts as singular.
"""

JOINT_NUMBERS = 4
ARMATURE, DAMPING, STIFFNESS, FRICTION = range(JOINT_NUMBERS)
"""Of each velocity: inertia of its motor that turns with it [kg or kg m²], viscous damping,
stiffness of its spring, about the rest that stands with its coordinate, and dry friction.
"""
