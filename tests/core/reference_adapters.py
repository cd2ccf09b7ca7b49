"""One adapter per kind of reference case: inputs of the case -> the outputs of the public API.

An adapter gets the inputs and returns a dictionary shaped like the outputs of the case. Nothing
here computes physics; integration in time, where a case asks for it, uses an integrator of the
tests (RK4) so that it is independent of the package.
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core import se2
from mecanum_base.core.combinations import table
from mecanum_base.core.command.goal import GoalConfig
from mecanum_base.core.command.potential_field import GoalField
from mecanum_base.core.command.trajectory import CircleSpin
from mecanum_base.core.contact import odometry as exact
from mecanum_base.core.contact import passage as passages
from mecanum_base.core.contact import rate as contact
from mecanum_base.core.dynamics import body as bodies
from mecanum_base.core.dynamics import forces, loads, motion
from mecanum_base.core.kinematics import layouts, mobility, mounting, solve, tlale
from mecanum_base.core.kinematics.lines import name_motion, roller_lines
from mecanum_base.core.kinematics.matrix import effective_roller, wheels_from_body
from mecanum_base.core.kinematics.wheels import Wheels
from mecanum_base.core.platform import constraints, differential, lie
from mecanum_base.core.platform.carriers import Carriers
from mecanum_base.core.platform.hinges import Hinges
from mecanum_base.core.roller import shape as shapes
from mecanum_base.core.roller import sizing
from mecanum_base.core.roller import torus as tori
from mecanum_base.core.slip import drive, encoder, ratio
from mecanum_base.core.turning import pivot, two_wheel

ADAPTERS = {}
TLALE_NAMES = ('FR', 'FL', 'RL', 'RR')


def adapter(function):
    ADAPTERS[function.__name__] = function
    return function


def wheels_of(items):
    """A wheel table; k and d (roller count, pin radius) may be absent."""
    def column(key, default=None):
        return [item.get(key, default) for item in items]
    return Wheels(tuple(f'wheel_{i}' for i in range(len(items))), column('x'), column('y'),
                  column('axis_angle'), column('roller_angle'), column('radius'),
                  np.array(column('k', 0)), column('d', 0.0))


def nominal(wheels):
    return Wheels(wheels.joint, wheels.x, wheels.y, wheels.axle, wheels.roller, wheels.radius)


def rectangle_of(i, roller=math.pi / 4):
    return layouts.rectangle(i['lx'], i['ly'], i['r'], i.get('roller_angle', roller))


def tlale_base(i):
    return layouts.rectangle(i['wheelbase_y'] / 2, i['track_x'] / 2, i['r'], i['alpha'])


def in_tlale_order(values):
    return np.asarray(values)[list(layouts.TLALE)]


def integrate(slope, state, time, steps):
    """Fourth-order Runge-Kutta, independent of the package."""
    h = time / steps
    for n in range(steps):
        t = n * h
        k1 = slope(t, state)
        k2 = slope(t + h / 2, state + h / 2 * k1)
        k3 = slope(t + h / 2, state + h / 2 * k2)
        k4 = slope(t + h, state + h * k3)
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return state


# --- kinematics -----------------------------------------------------------------------------

@adapter
def rect_ik(i):
    rates = wheels_from_body(rectangle_of(i)) @ np.array(i['twist'])
    return dict(zip(layouts.RECTANGLE, rates))


@adapter
def rect_fk(i):
    matrix, rates = wheels_from_body(rectangle_of(i)), np.array(i['rates_FL_FR_RL_RR'])
    twist = solve.body_from_wheels(matrix) @ rates
    return {'twist': twist, 'residual_rates': solve.parity_projector(matrix) @ rates,
            'parity_FL_FR_mRL_mRR': solve.null_vector(matrix) @ rates}


@adapter
def rect_angle(i):
    matrix, rates = wheels_from_body(rectangle_of(i)), np.array(i['rates_FL_FR_RL_RR'])
    return {'rates_from_twist': matrix @ np.array(i['twist']),
            'twist_from_rates': solve.body_from_wheels(matrix) @ rates,
            'residual_rates': solve.parity_projector(matrix) @ rates}


@adapter
def general_ik(i):
    return {'rates': wheels_from_body(wheels_of(i['wheels'])) @ np.array(i['twist'])}


@adapter
def general_fk(i):
    wheels, rates = wheels_of(i['wheels']), np.array(i['rates'])
    matrix = wheels_from_body(wheels)
    plain = solve.body_from_wheels(matrix) @ rates
    weighted = solve.body_from_wheels(matrix, solve.weights(wheels, 'slip')) @ rates
    return {'twist_ls_wheel_speed': plain, 'residual_wheel_speed': rates - matrix @ plain,
            'twist_ls_slip': weighted, 'residual_slip_mps': ratio.slip_speed(
                wheels, rates, weighted)}


@adapter
def slip_projector(i):
    projector = solve.parity_projector(wheels_from_body(wheels_of(i['wheels'])))
    part = projector @ np.array(i['rates'])
    return {'projector': projector, 'inconsistent_part': part,
            'consistent': bool(np.max(np.abs(part)) < 1e-7 * np.max(np.abs(i['rates'])))}


@adapter
def asym4(i):
    wheels, rates = wheels_of(i['wheels']), np.array(i['rates'])
    matrix = wheels_from_body(wheels)
    plain = solve.body_from_wheels(matrix) @ rates
    return {'rates_from_twist': matrix @ np.array(i['twist']), 'twist_ls_wheel_speed': plain,
            'residual_wheel_speed': rates - matrix @ plain,
            'twist_ls_slip': solve.body_from_wheels(matrix, solve.weights(wheels, 'slip')) @ rates,
            'null_vector_max1': solve.null_vector(matrix)}


@adapter
def theorem2(i):
    wheels = wheels_of(i['wheels'])
    verdict = mobility.assess(wheels)
    found = {'M': roller_lines(wheels), 'det_M': np.linalg.det(roller_lines(wheels)),
             'singular': verdict.rank < 3}
    if verdict.self_motion is not None:
        motion_ = name_motion(verdict.self_motion)
        if motion_.kind == 'rotation':
            found['self_motion'] = {'type': 'rotation', 'centre': motion_.centre,
                                    'twist_per_unit_omega': motion_.twist}
        else:
            found['self_motion'] = {'type': 'translation', 'direction_up_to_sign': motion_.twist}
    return found


@adapter
def mounting_case(i):
    wheels = wheels_of(i['wheels'])
    rank = mobility.assess(wheels).rank
    return {'rank': rank, 'yaw_lever': mounting.yaw_lever(wheels)[:2], 'singular': rank < 3}


ADAPTERS['mounting'] = ADAPTERS.pop('mounting_case')


def _ring(i):
    wheels = layouts.swedish_ring(i['L'], i['r'], i['mount_angles'])
    matrix, rates = wheels_from_body(wheels), np.array(i['rates'])
    twist = solve.body_from_wheels(matrix) @ rates
    return {'rates_from_twist': matrix @ np.array(i['twist']), 'twist_from_rates': twist,
            'residual_rates': rates - matrix @ twist}


@adapter
def swedish3(i):
    return _ring(i)


@adapter
def swedish4(i):
    return _ring(i)


@adapter
def se2_step(i):
    return {'pose': se2.compose(np.array(i['pose']), se2.exp(np.array(i['twist']) * i['dt']))}


@adapter
def square_drive(i):
    matrix = wheels_from_body(rectangle_of(i))
    pose, legs = np.zeros(3), []
    for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1)):
        step = i['side'] * np.array([x, y, 0.0])
        legs.append(matrix @ step)
        pose = se2.compose(pose, se2.exp(solve.body_from_wheels(matrix) @ legs[-1]))
    return {'wheel_angle_per_leg_FL_FR_RL_RR': legs, 'end_pose': pose}


# --- rollers and contact --------------------------------------------------------------------

def _shape(i):
    return shapes.RollerShape(i['r'], i['d'], i['delta'])


@adapter
def roller_points(i):
    shape, u = _shape(i), np.array([i['u']])
    along, radius = shapes.meridian(shape, u)
    return {'curve_S': shapes.contact_curve(shape, u)[0],
            'curve_Sstar': shapes.contact_curve_of_roller(shape, u)[0],
            'surface_Sstar': shapes.surface(shape, u, np.array([i['v']]))[0],
            'meridian_xstar': along[0], 'meridian_radius': radius[0],
            'knot_K': shapes.knot_point(shape), 'knot_u': shape.knot,
            'equator_radius': shape.equator_radius}


@adapter
def torus(i):
    shape, u = _shape(i), np.array([i['u']])
    found = tori.torus_of(shape)
    return {'r_t': found.centre_radius, 'r_m': found.meridian_radius,
            'meridian_deviation': tori.meridian_deviation(shape, u)[0],
            'axis_height_error': tori.axis_height_error(shape, u)[0],
            'axis_height_error_leading': tori.axis_height_error_leading(shape, u)[0]}


@adapter
def roller_sizing(i):
    found = sizing.size(_shape(i), i['k'], i['roller_length'])
    return {'half_range': found.half_range, 'min_roller_length': found.min_length,
            'max_roller_length': found.max_length, 'max_half_range': found.max_half_range,
            'half_range_of_roller': found.reach, 'contact_ratio': found.contact_ratio,
            'equator_radius': found.equator_radius, 'radius_at_handover': found.handover_radius,
            'end_radius': found.end_radius, 'contact_travel': found.contact_travel,
            'axis_drop_at_gap': found.axis_drop}


@adapter
def exact_rate(i):
    wheels, angle = wheels_of([i['wheel']]), np.array([i['theta']])
    twist = np.array(i['twist'])
    return {'u': contact.phase(wheels, angle)[0],
            'contact_xy': contact.contact_points(wheels, angle)[0],
            'roller_axis_b': contact.roller_axes(wheels, angle)[0],
            'rate': (contact.wheels_from_body(wheels, angle) @ twist)[0],
            'rate_nominal_eq16': (wheels_from_body(wheels, corrected=False) @ twist)[0],
            'roller_spin_about_b': contact.roller_spins(wheels, angle, twist)[0],
            'roller_peripheral_lambda': contact.roller_speeds(wheels, angle, twist)[0],
            'roller_local_radius': contact.local_radii(wheels, angle)[0]}


@adapter
def passage(i):
    found = passages.passage(wheels_of([i['wheel']]), np.array(i['twist']))
    return {'rate_nominal': found.nominal[0], 'rate_min': found.low[0], 'rate_max': found.high[0],
            'rate_mean_over_angle': found.mean[0], 'handover_jump': found.jump[0],
            'contact_jump': found.travel[0]}


@adapter
def lateral_scale(i):
    wheels = Wheels(('w',), [0.0], [0.0], [math.pi / 2], [i['roller_angle']], [i['r']],
                    np.array([i['k']]))
    step = passages.lateral_travel(wheels)[0] * i['pitches']
    return {'lateral_exact': step, 'lateral_nominal': step / passages.lateral_scale(i['k']),
            'ratio_exact_to_nominal': passages.lateral_scale(i['k']),
            'peak_rate_ratio': passages.lateral_peak(i['k']),
            'effective_roller_angle': effective_roller(wheels)[0]}


@adapter
def exact_fk(i):
    wheels, rates = wheels_of(i['wheels']), np.array(i['rates'])
    angles = np.array(i['thetas'])
    twist = exact.exact_twist(wheels, angles, rates)
    return {'twist_exact': twist,
            'twist_nominal': solve.body_from_wheels(
                wheels_from_body(wheels, corrected=False)) @ rates,
            'residual': rates - contact.wheels_from_body(wheels, angles) @ twist}


def _odometry(i, name):
    wheels = wheels_of(i['wheels'])
    turns = np.array(i['rates']) * i['duration']
    plain, averaged = (se2.exp(solve.body_from_wheels(
        wheels_from_body(wheels, corrected=corrected)) @ turns) for corrected in (False, True))
    start = np.array(i['theta0'])
    return {name: exact.integrate(wheels, start, turns), 'pose_nominal': plain,
            'pose_effective_angle': averaged,
            'handovers': len(exact.handovers(wheels, start, turns))}


@adapter
def exact_odometry(i):
    return _odometry(i, 'pose_exact')


@adapter
def exact_odometry4(i):
    return _odometry(i, 'pose_exact_ls')


# --- source T: slip, velocity, force, turning, dynamics ---------------------------------------

@adapter
def encoder_rate(i):
    constant = encoder.encoder_constant(i['pulses_per_rev'], i['quadrature'],
                                        i['gear_ratio_motor_to_wheel'])
    return {'C': constant,
            'wheel_rate': encoder.rate_from_counts(i['delta_pulses'], i['dt'], constant)}


@adapter
def encoder_odometry(i):
    constant = encoder.encoder_constant(i['pulses_per_rev'], i['quadrature'],
                                        i['gear_ratio_motor_to_wheel'])
    inverse, pose = solve.body_from_wheels(wheels_from_body(rectangle_of(i))), np.zeros(3)
    for counts in i['increments_FL_FR_RL_RR']:
        turns = encoder.rate_from_counts(np.array(counts, dtype=float), 1.0, constant)
        pose = se2.compose(pose, se2.exp(inverse @ turns))
    return {'pose': pose}


@adapter
def effective_rate(i):
    return {'wheel_rate': drive.wheel_rate(i['motor_rate'], i['gear_factor_n']),
            'effective_rate': drive.effective_rate(i['motor_rate'], i['gear_factor_n'],
                                                   i['roller_angle']),
            'effectiveness': drive.effectiveness(i['roller_angle'])}


@adapter
def slip(i):
    wheels, twist = wheels_of([i['wheel']]), np.array(i['twist_true'])
    rates = np.array([i['wheel_rate']])
    s = ratio.slip_ratio(wheels, rates, twist)[0]
    return {'real_travel_along_roller_axis': ratio.real_travel(wheels, twist, i['dt'])[0],
            'wheel_travel_along_roller_axis': ratio.wheel_travel(wheels, rates, i['dt'])[0],
            'travel_ratio_s': s, 'slip_1_minus_s': 1.0 - s,
            'slip_speed_mps': ratio.slip_speed(wheels, rates, twist)[0]}


@adapter
def tlale_velocity(i):
    rates = np.array(i['rates_1FR_2FL_3RL_4RR'])
    right, forward = tlale.printed_sums(i['r'], i['alpha'], rates)
    twist = tlale.twist_from_rates(i['track_x'], i['wheelbase_y'], i['r'], i['alpha'], rates)
    world = tlale.world_velocity(i['phi'], twist[0], -twist[1])
    return {'sum_x_right_as_printed_K1': right, 'sum_y_forward_without_minus1_power_K1': forward,
            'twist_rep103': twist, 'v_right': -twist[1], 'v_forward': twist[0],
            'world_velocity': world, 'beta': tlale.travel_bearing(world)}


@adapter
def tlale_force(i):
    force, sign, k = (np.array(i[key], dtype=float) for key in ('FT', 'SIG', 'K'))
    right, forward = forces.tlale_forces(force, i['alpha'], sign, k)
    world = forces.world_force(i['phi'], right, forward)
    effective, lost = forces.split(force, i['alpha'])
    ideal_right, ideal_forward = forces.ideal_forces(force, i['alpha'], sign)
    one = Wheels(('w',), [0.0], [0.0], [math.pi / 2], [-i['alpha']], [1.0])
    return {'sum_Fx_right': right, 'sum_Fy_forward': forward, 'world_force': world,
            'world_accel': world / i['mass'], 'ineffective_slip_force': lost,
            'effective_force': effective,
            'ideal_roller_force_along_axis': [forces.roller_forces(one, f)[0] for f in force],
            'ideal_body_force_forward_left': [ideal_forward, -ideal_right]}


@adapter
def wrench(i):
    wheels, torques = wheels_of(i['wheels']), np.array(i['torques'])
    return {'wrench_Fx_Fy_Mz': forces.wrench_from_torques(wheels, torques),
            'roller_axis_force': forces.roller_forces(wheels, torques)}


@adapter
def tlale_torque(i):
    torque, lever = forces.yaw_torque(i['track_x'], i['wheelbase_y'], i['alpha'],
                                      np.array(i['roller_axis_forces_1FR_2FL_3RL_4RR']))
    distance, xi = forces.roller_bearing(i['track_x'], i['wheelbase_y'], i['alpha'])
    return {'l': distance, 'xi': xi, 'lever_arm': lever, 'torque_ccw': torque}


@adapter
def pivot_wheel(i):
    base, index = tlale_base(i), layouts.RECTANGLE.index(i['pivot'])
    turn = pivot.pivot_turn(base, index, i['omega'])
    return {'rates_1FR_2FL_3RL_4RR': in_tlale_order(turn.rates), 'twist': turn.twist,
            'centre_speed': np.hypot(*turn.twist[:2]), 'R_pivot_to_centre': turn.radius}


@adapter
def two_wheel_turn(i):
    base = tlale_base(i)
    locked = [layouts.RECTANGLE.index(name) for name in i['locked']]
    turn = two_wheel.locked_turn(base, locked, i['omega'])
    idle = next(k for k in range(4) if k not in locked)
    return {'icr_body_xy': turn.centre, 'R': turn.radius, 'twist': turn.twist,
            'R_driven': math.hypot(base.x[idle] - turn.centre[0], base.y[idle] - turn.centre[1]),
            'rates_1FR_2FL_3RL_4RR': in_tlale_order(turn.rates)}


def _dynamics(i):
    body = bodies.Body(i['mass'], i['inertia_about_mass_centre'], i['mass_centre'])
    return wheels_of(i['wheels']), body, bodies.DriveTrain(i['wheel_inertia'], i['wheel_viscous'])


@adapter
def forward_dynamics(i):
    wheels, body, train = _dynamics(i)
    twist = np.array(i['twist'])
    return {'twist_rate': motion.forward_dynamics(wheels, body, train, twist,
                                                  np.array(i['torques'])),
            'mass_matrix_body': bodies.mass_matrix(body),
            'coriolis': bodies.coriolis(body, twist)}


@adapter
def inverse_dynamics(i):
    wheels, body, train = _dynamics(i)
    twist, rate = np.array(i['twist']), np.array(i['twist_rate'])
    return {'body_wrench': motion.body_wrench(body, twist, rate),
            'torques_min_norm': motion.inverse_dynamics(wheels, body, train, twist, rate)}


@adapter
def step_response(i):
    base = rectangle_of(i)
    body = bodies.Body(i['mass'], 1.0)
    train = bodies.DriveTrain(i['wheel_inertia'], i['wheel_viscous'])
    torques = np.full(4, i['torque_each'])

    def slope(_, state):
        return np.concatenate([state[3:], motion.forward_dynamics(base, body, train, state[3:],
                                                                  torques)])
    end = integrate(slope, np.zeros(6), i['t'], 200)
    return {'forward_speed': end[3], 'distance': end[0]}


@adapter
def normal_loads(i):
    contacts = i['lx'] * np.array([1, 1, -1, -1]), i['ly'] * np.array([1, -1, 1, -1])
    bilinear = loads.bilinear_loads(i['lx'], i['ly'], i['mass'], np.array(i['mass_centre']),
                                    gravity=i['g'])
    spring = loads.spring_loads(np.column_stack(contacts), i['mass'], np.array(i['mass_centre']),
                                height=i['height'], acceleration=np.array(i['accel_body']),
                                gravity=i['g'])
    return {'static_bilinear_FL_FR_RL_RR': bilinear,
            'friction_limit_bilinear': loads.friction_limits(bilinear, i['mu']),
            'equal_stiffness_with_accel_FL_FR_RL_RR': spring,
            'liftoff': bool(np.any(spring < 0.0))}


@adapter
def normal_loads3(i):
    return {'loads': loads.spring_loads(np.array(i['contacts']), i['mass'],
                                        np.array(i['mass_centre']), gravity=i['g'])}


# --- source D -------------------------------------------------------------------------------

def carriers_of(robots, angles=(0.0, 0.0)):
    def column(key):
        return [robot[key] for robot in robots]
    return Carriers(('one', 'two'), column('x'), column('y'), column('e'), column('b'),
                    column('r'), ('one_left', 'two_left'), ('one_right', 'two_right'),
                    initial_angle=angles)


def hinges_of(robots):
    return Hinges([r['x'] for r in robots], [r['y'] for r in robots], [r['e'] for r in robots])


@adapter
def dualdiff_ik(i):
    carriers, angles = carriers_of(i['robots']), np.array(i['thetas'])
    yaw, twist = i['platform_pose'][2], np.array(i['twist_platform_axes'])
    state = constraints.state_from_body(carriers, angles, yaw)
    return {'theta_rates': differential.hinges_from_body(carriers, angles) @ twist,
            'wheel_rates': (differential.wheels_from_body(carriers, angles) @ twist).reshape(2, 2),
            'state_rates': state @ twist, 'S_matrix': state, 'pfaffian_rank': constraints.rank(
                constraints.constraint_matrix(carriers, angles, yaw))}


@adapter
def dualdiff_fk(i):
    carriers, angles = carriers_of(i['robots']), np.array(i['thetas'])
    rates = np.ravel(i['wheel_rates'])
    return {'twist_platform_axes': differential.body_from_wheels(carriers, angles) @ rates,
            'theta_rates': differential.hinges_from_wheels(carriers, angles) @ rates}


@adapter
def dualdiff_mobility(i):
    found = constraints.assess(hinges_of(i['robots']), np.array(i['thetas']))
    return {'rank_lateral': found.lateral_rank, 'degree_of_mobility_posture5': found.degree,
            'platform_twist_dof': found.twist_dof, 'omnidirectional': found.omnidirectional}


@adapter
def dualdiff_lie(i):
    hinges, angles, yaw = hinges_of(i['robots']), np.array(i['thetas']), i['theta_p']
    one, two, three = lie.fields(hinges, angles, yaw).T
    plain, bracketed = lie.reachable_rank(hinges, angles, yaw)
    return {'g1': one, 'g2': two, 'g3': three, 'g1g2': lie.bracket(hinges, angles, yaw, 0, 1),
            'g1g3': lie.bracket(hinges, angles, yaw, 0, 2),
            'g2g3': lie.bracket(hinges, angles, yaw, 1, 2),
            'rank_distribution': plain, 'rank_first_brackets': bracketed}


@adapter
def circle_spin(i):
    path = CircleSpin(i['R'], i['angular_rate'], i['spin'], i['theta0'])
    return {'pose': path.pose(i['t']), 'world_velocity': path.velocity(i['t'])[:2],
            'twist_platform_axes': path.twist(i['t'])}


@adapter
def dualdiff_trajectory(i):
    carriers = carriers_of(i['robots'], i['thetas0'])
    path = CircleSpin(i['R'], i['angular_rate'], i['spin'], i['theta0_platform'])

    def slope(time, state):
        twist = path.twist(time)
        return np.concatenate([differential.hinges_from_body(carriers, state[:2]) @ twist,
                               differential.wheels_from_body(carriers, state[:2]) @ twist])
    end = integrate(slope, np.concatenate([i['thetas0'], np.zeros(4)]), i['T'], 1500)
    return {'thetas': end[:2], 'wheel_angles': end[2:].reshape(2, 2)}


def _field(i):
    return GoalField(GoalConfig(max_speed=i['v_max'], max_yaw_rate=i.get('omega_max', 1.0),
                                slow_radius=i['K_r'], stop_radius=i['K_stop']))


@adapter
def potential_law(i):
    pose, goal = np.array(i['pose']), np.array(i['goal'])
    twist = _field(i).twist(pose, goal, i['theta_ref'])
    gap = goal - pose[:2]
    return {'distance': np.hypot(*gap), 'theta_g': math.atan2(gap[1], gap[0]), 'vx': twist[0],
            'vy': twist[1], 'omega': twist[2]}


@adapter
def potential_closed_loop(i):
    field, goal = _field(i), np.zeros(2)
    bearing, heading = 0.6, 0.3  # any: the law is the same in all directions
    start = np.array([-i['start_distance'] * math.cos(bearing),
                      -i['start_distance'] * math.sin(bearing), heading])
    reference = heading + i['start_heading_error']

    def slope(_, pose):
        twist = field.twist(pose, goal, reference)
        return np.concatenate([se2.rotation(pose[2]) @ twist[:2], twist[2:]])
    # both radii are kinks: integrate from one to the next, so that RK4 keeps its order
    kink = max(0.0, (i['start_distance'] - i['K_r']) / i['v_max'])
    near = min(i['start_distance'], i['K_r'])
    stop = kink + (math.log(near / i['K_stop']) * i['K_r'] / i['v_max'] if i['K_stop'] else 1e9)
    pose, past = start, 0.0
    for end, steps in ((kink, 400), (stop, 1000), (i['t'], 400)):
        end = min(end, i['t'])
        pose = integrate(slope, pose, end - past, steps) if end > past else pose
        past = max(past, end)
    return {'distance': np.hypot(*pose[:2]), 'heading_error': reference - pose[2]}


@adapter
def potential_circle_lag(i):
    field = _field(i)
    path = CircleSpin(i['R'], i['angular_rate'], 0.0)
    tau = i['K_r'] / i['v_max']

    def slope(time, pose):
        twist = field.twist(pose, path.pose(time), 0.0)
        return np.concatenate([se2.rotation(pose[2]) @ twist[:2], twist[2:]])
    time = 25.0 * tau  # the start dies out as exp(-t/tau)
    pose, goal = integrate(slope, path.pose(0.0), time, 1500), path.pose(time)
    lag = math.atan2(goal[1], goal[0]) - math.atan2(pose[1], pose[0])
    # the goal runs clockwise, so a base that lags behind lies counter-clockwise of it
    return {'tau': tau, 'steady_radius': np.hypot(*pose[:2]),
            'steady_distance': np.hypot(*(goal - pose)[:2]), 'phase_lag': -se2.wrap_angle(lag)}


# --- combinations ---------------------------------------------------------------------------

@adapter
def combinations81(i):
    rate = i['unit_rate']
    found = table.survey(rectangle_of(i), rate)
    counts = table.count(found)
    rows, labels = {}, {}
    for item in found:
        verdict = item.verdict
        rows[item.pattern] = {
            'driven': verdict.driven, 'parity': verdict.parity / rate,
            'twist_ls_unit_rate': verdict.twist / rate, 'no_slip_locked': verdict.no_slip,
            'rest_is_equilibrium_locked': verdict.stalls, 'freewheel': verdict.free_idle}
        if item.label:
            labels[item.pattern] = {'label': item.label, 'ls_bearing_deg': item.compass,
                                    'ls_yaw': verdict.twist[2]}
    return {'counts': {'total': counts.total, 'no_slip': counts.no_slip,
                       'parity_le_1': counts.parity_within_one, 'stop': counts.stop,
                       'rest_equilibrium_nonzero': counts.stalled,
                       'ls_zero_twist': counts.no_twist},
            'table': rows, 'table_I': labels}
