"""One physics step of the whole base, linearly implicit, in plain scalars.

Rigid body with mass centre C (models.md 1.3, about C so that no Coriolis terms appear):

    m dv_C/dt = F,   I_C dw/dt = M_C                      v_C in floor axes, w about z
    s_b = b . (v_A + w x AC') + r u (a_perp . b)          slip speed along the roller axis b
    I_w du/dt = tau_motor - tau_bearing - r (a_perp . F_contact)          (models.md 1.2, T5)
    F_b = -N (sigma0 z + sigma1 dz/dt),   dz/dt = s - z sqrt((sigma0 s / g(s))^2 + (kappa v_A)^2)
    g(s) = mu_k + (mu_s - mu_k) exp(-(s/v_s)^2)           static peak, Coulomb plateau
    F_t = -N mu_r s_t / sqrt(s_t^2 + v_0^2)               drag of the roller bearing, across b

b, contact point and lever are those of the momentary roller (models.md 2.1, G10, G11). z is the
shear of the contact (LuGre law; Canudas de Wit et al. 1995), kappa v_A its renewal by rolling (as
Canudas de Wit & Tsiotras 1999, but joined by the root of squares, so that a locked wheel still
slides at mu_k): creep is proportional to force and speed, s / v_A = F_b kappa / (N sigma0).
Forces are linear in the new speeds with frozen factors, so wheels, hinges and shear are eliminated
and a symmetric 3x3 system remains: stable at any stiffness. Heave, roll and pitch on the supports
(equal stiffness, unilateral) give the loads, symplectic Euler.

Tyres of carrier wheels use the same law along and across. Not modelled: winding inductance, spin
friction of the contact, roller inertia, gyroscopic moments of wheels, carriers that tilt (each is
taken to stand by itself, with casters that carry nothing).
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence, Sequence

from mecanum_base.sim.ground import ground

from mecanum_base.sim.layout import (  # isort: skip
    BACK_EMF, BEARING, CORNER, CX, CY, GRAVITY_X, GRAVITY_Y, H_ANGLE, H_D, H_INERTIA, H_KX, H_KY,
    H_KZ, H_RATE, H_RHS, H_X, H_Y, HINGE, I_DROP, I_FREE, I_GRIP, I_JAM, I_RATE, INERTIA, INPUT,
    KAPPA, KI, KINETIC, KP, MASS, R_AB, R_AT, R_BB, R_BH, R_BT, R_BX, R_BY, R_BZ, R_DECAY,
    R_MOTOR, R_P, R_Q, R_RHO_B, R_RHO_T, R_TH, R_TX, R_TY, R_TZ, ROLLER_DRAG, ROW, S_BVX, S_BVY,
    S_GROUND_MZ, S_GROUND_X, S_GROUND_Y, S_HEAVE, S_HEAVE_RATE, S_PITCH, S_PITCH_RATE, S_ROLL,
    S_ROLL_RATE, S_VX, S_VY, S_W, S_X, S_Y, S_YAW, SIGMA0, SIGMA1, STATIC, STRIBECK, SUPPORT_C,
    SUPPORT_K, T_ANGLE, T_FORCE, T_FORCE_SIDE, T_INTEGRAL, T_LOAD, T_RATE, T_SHEAR, T_SHEAR_SIDE,
    T_SLIP, T_SLIP_ANGLE, T_SLIP_RATE, T_SLIP_SIDE, T_TORQUE, TORQUE_LIMIT, TORQUE_PER_VOLT,
    TURN, VISCOUS, VOLT_LIMIT, W_AX, W_AY, W_COS, W_HINGE, W_PHASE, W_PITCH, W_RADIUS, W_REACH,
    W_RUNOUT, W_RUNOUT_PHASE, W_SIN, W_TYRE, W_X, W_Y, WALL, WALL_C, WALL_K, WHEEL,
    WHEEL_INERTIA,
)
from mecanum_base.sim.lean import lean

DRAG_SPEED = 0.005  # m/s, below which roller drag fades
BEARING_SPEED = 0.05  # rad/s, below which bearing friction fades
NO_LOAD = 1e-9  # N


def advance(
    steps: int, dt: float, body: Sequence[float], wheels: Sequence[float],
    patches: Sequence[float], waves: Sequence[float], ramps: Sequence[float],
    walls: Sequence[float], corners: Sequence[float], push: Sequence[float],
    inputs: Sequence[float], state: MutableSequence[float], turn: MutableSequence[float],
    hinges: MutableSequence[float], row: MutableSequence[float],
) -> None:
    """Advance the tables ``state``, ``turn`` and ``hinges`` by ``steps`` steps of ``dt`` [s].

    ``push`` is force x, y (body axes), torque z, force x, y (floor axes) [N, N m].
    """
    count = len(wheels) // WHEEL
    mass, inertia, cx, cy = body[MASS], body[INERTIA], body[CX], body[CY]
    sigma0, sigma1, kappa = body[SIGMA0], body[SIGMA1], body[KAPPA]
    stribeck = 1.0 / (body[STRIBECK] * body[STRIBECK])
    wheel_inertia, kp, ki = body[WHEEL_INERTIA], body[KP], body[KI]
    per_volt, emf = body[TORQUE_PER_VOLT], body[BACK_EMF]
    volt_limit, torque_limit = body[VOLT_LIMIT], body[TORQUE_LIMIT]
    for _ in range(steps):
        yaw_rate = state[S_W]
        middle = state[S_YAW] + 0.5 * dt * yaw_rate
        cosine, sine = math.cos(middle), math.sin(middle)
        # velocity of the mass centre in body axes of the mid-step
        vx0 = cosine * state[S_VX] + sine * state[S_VY]
        vy0 = cosine * state[S_VY] - sine * state[S_VX]
        fx = push[0] + cosine * push[3] + sine * push[4]
        fy = push[1] + cosine * push[4] - sine * push[3]
        fz = push[2]
        fx += mass * (cosine * body[GRAVITY_X] + sine * body[GRAVITY_Y])
        fy += mass * (cosine * body[GRAVITY_Y] - sine * body[GRAVITY_X])
        for j in range(0, len(walls), WALL):
            for k in range(0, len(corners), CORNER):
                rx, ry = corners[k] - cx, corners[k + 1] - cy
                px = state[S_X] + cosine * rx - sine * ry
                py = state[S_Y] + sine * rx + cosine * ry
                depth = walls[j + 2] - (walls[j] * px + walls[j + 1] * py)
                if depth > 0.0:
                    nx = cosine * walls[j] + sine * walls[j + 1]
                    ny = cosine * walls[j + 1] - sine * walls[j]
                    speed = nx * (vx0 - yaw_rate * ry) + ny * (vy0 + yaw_rate * rx)
                    force = body[WALL_K] * depth - body[WALL_C] * speed
                    if force > 0.0:
                        fx += force * nx
                        fy += force * ny
                        fz += force * (rx * ny - ry * nx)
        heave, roll, pitch = state[S_HEAVE], state[S_ROLL], state[S_PITCH]
        lift_sum, roll_moment, pitch_moment = 0.0, 0.0, 0.0
        m11, m12, m13 = mass / dt, 0.0, 0.0
        m22, m23, m33 = mass / dt, 0.0, inertia / dt
        b1 = mass / dt * vx0
        b2 = mass / dt * vy0
        b3 = inertia / dt * yaw_rate
        for c in range(0, len(hinges), HINGE):
            hinges[c + H_D] = hinges[c + H_INERTIA] / dt
            hinges[c + H_RHS] = hinges[c + H_INERTIA] / dt * hinges[c + H_RATE]
            hinges[c + H_KX] = 0.0
            hinges[c + H_KY] = 0.0
            hinges[c + H_KZ] = 0.0
        for i in range(count):
            w, t, n, q = i * WHEEL, i * TURN, i * INPUT, i * ROW
            angle, rate = turn[t + T_ANGLE], turn[t + T_RATE]
            ax, ay = wheels[w + W_AX], wheels[w + W_AY]
            x, y = wheels[w + W_X], wheels[w + W_Y]
            radius = wheels[w + W_RADIUS]
            if wheels[w + W_RUNOUT] != 0.0:
                radius += wheels[w + W_RUNOUT] * math.cos(angle + wheels[w + W_RUNOUT_PHASE])
            tyre = wheels[w + W_TYRE] != 0.0
            carrier = int(wheels[w + W_HINGE]) * HINGE
            lever_x, lever_y, spin = 0.0, 0.0, yaw_rate
            if carrier >= 0:  # wheel of a carrier: turn with the hinge
                hc, hs = math.cos(hinges[carrier + H_ANGLE]), math.sin(hinges[carrier + H_ANGLE])
                ax, ay = hc * ax - hs * ay, hs * ax + hc * ay
                lever_x, lever_y = hc * x - hs * y, hs * x + hc * y
                x = hinges[carrier + H_X] + lever_x
                y = hinges[carrier + H_Y] + lever_y
                spin = hinges[carrier + H_RATE]
            if tyre:
                bx, by = -ay, ax  # rolling direction (backwards)
            else:
                cosd, sind = wheels[w + W_COS], wheels[w + W_SIN]
                cosu = 1.0
                if wheels[w + W_PITCH] > 0.0:  # phase of the roller on the ground
                    width = wheels[w + W_PITCH]
                    phase = angle + wheels[w + W_PHASE]
                    phase -= width * math.floor(phase / width + 0.5)
                    cosu = math.cos(phase)
                    reach = wheels[w + W_REACH] * math.sin(phase) / cosu  # G11
                    x -= reach * ax
                    y -= reach * ay
                bx = ax * cosd - ay * sind * cosu  # G10, its part in the floor
                by = ay * cosd + ax * sind * cosu
                norm = 1.0 / math.sqrt(bx * bx + by * by)
                bx *= norm
                by *= norm
            tx, ty = -by, bx
            rx, ry = x - cx, y - cy
            # load
            px = state[S_X] + cosine * rx - sine * ry
            py = state[S_Y] + sine * rx + cosine * ry
            static, kinetic, drag, rise, slope_x, slope_y = ground(
                px, py, body[STATIC], body[KINETIC], patches, waves, ramps)
            hinge_x, hinge_y = rx - lever_x, ry - lever_y
            stand_x, stand_y = rx, ry
            if carrier >= 0:  # carriers stand by themselves, whichever way they are turned
                stand_x, stand_y = hinge_x, hinge_y + wheels[w + W_Y]
            vx = vx0 - yaw_rate * hinge_y - spin * lever_y
            vy = vy0 + yaw_rate * hinge_x + spin * lever_x
            grade_x = cosine * slope_x + sine * slope_y
            grade_y = cosine * slope_y - sine * slope_x
            depth = rise - inputs[n + I_DROP] - (heave + roll * stand_y - pitch * stand_x)
            load = 0.0
            if depth > 0.0:
                sink = grade_x * vx + grade_y * vy - (
                    state[S_HEAVE_RATE] + state[S_ROLL_RATE] * stand_y
                    - state[S_PITCH_RATE] * stand_x)
                load = body[SUPPORT_K] * depth + body[SUPPORT_C] * sink
                if load < 0.0:
                    load = 0.0
            turn[t + T_LOAD] = load
            lift_sum += load
            roll_moment += load * stand_y
            pitch_moment -= load * stand_x
            fx -= load * grade_x
            fy -= load * grade_y
            fz -= load * (rx * grade_y - ry * grade_x)
            # friction, linear in the new slip: force = -(alpha + beta * slip)
            rho_b = radius * (ax * by - ay * bx)
            rho_t = radius * (ax * ty - ay * tx)
            slip_b = bx * vx + by * vy + rho_b * rate
            slip_t = tx * vx + ty * vy + rho_t * rate
            ab, bb, at, bt, decay = 0.0, 0.0, 0.0, 0.0, 0.0
            if load > NO_LOAD:
                square = slip_b * slip_b
                if tyre:
                    square += slip_t * slip_t
                level = kinetic  # g(s)
                if square * stribeck < 30.0:
                    level += (static - kinetic) * math.exp(-square * stribeck)
                level *= inputs[n + I_GRIP]
                gain = 0.0
                if level > 0.0:
                    decay = math.sqrt(square * (sigma0 / level) ** 2
                                      + (vx * vx + vy * vy) * kappa * kappa)
                    gain = load * (sigma0 + sigma1 / dt) / (1.0 + dt * decay)
                else:
                    turn[t + T_SHEAR], turn[t + T_SHEAR_SIDE] = 0.0, 0.0
                ab = (gain - load * sigma1 / dt) * turn[t + T_SHEAR]
                bb = gain * dt
                if tyre:
                    at = (gain - load * sigma1 / dt) * turn[t + T_SHEAR_SIDE]
                    bt = gain * dt
                else:
                    bt = load * body[ROLLER_DRAG] * drag / math.sqrt(
                        slip_t * slip_t + DRAG_SPEED * DRAG_SPEED)
            # motor under its PI loop, linear in the new wheel rate: torque = t0 - t1 * rate
            t0, t1 = 0.0, body[VISCOUS] + body[BEARING] / math.sqrt(
                rate * rate + BEARING_SPEED * BEARING_SPEED)
            motor0, motor1 = 0.0, 0.0
            if inputs[n + I_FREE] == 0.0:
                error = inputs[n + I_RATE] - rate
                ahead = emf * inputs[n + I_RATE] + ki * turn[t + T_INTEGRAL]
                volt = ahead + kp * error
                bound = 0.0  # +1 or -1 at a limit
                if volt > volt_limit:
                    bound = 1.0
                elif volt < -volt_limit:
                    bound = -1.0
                if bound != 0.0:
                    motor0, motor1 = per_volt * bound * volt_limit, per_volt * emf
                else:
                    motor0 = per_volt * (ahead + kp * inputs[n + I_RATE])
                    motor1 = per_volt * (kp + emf)
                torque = motor0 - motor1 * rate
                if torque > torque_limit:
                    motor0, motor1, bound = torque_limit, 0.0, 1.0
                elif torque < -torque_limit:
                    motor0, motor1, bound = -torque_limit, 0.0, -1.0
                if bound * error <= 0.0:  # no wind-up at a limit
                    turn[t + T_INTEGRAL] += dt * error
            else:
                turn[t + T_INTEGRAL] = 0.0
            t0 += motor0
            t1 += motor1
            # eliminate the wheel rate: rate = (p - ...) * q
            p = wheel_inertia / dt * rate + t0 - rho_b * ab - rho_t * at
            inverse = 1.0 / (wheel_inertia / dt + t1 + rho_b * rho_b * bb + rho_t * rho_t * bt)
            if inputs[n + I_JAM] != 0.0:
                inverse = 0.0
            kbb = bb - bb * rho_b * bb * rho_b * inverse
            ktt = bt - bt * rho_t * bt * rho_t * inverse
            kbt = -bb * rho_b * bt * rho_t * inverse
            free = p * inverse
            lb = ab + bb * rho_b * free
            lt = at + bt * rho_t * free
            bz = hinge_x * by - hinge_y * bx
            tz = hinge_x * ty - hinge_y * tx
            hx_b, hy_b, hz_b = kbb * bx + kbt * tx, kbb * by + kbt * ty, kbb * bz + kbt * tz
            hx_t, hy_t, hz_t = kbt * bx + ktt * tx, kbt * by + ktt * ty, kbt * bz + ktt * tz
            m11 += bx * hx_b + tx * hx_t
            m12 += bx * hy_b + tx * hy_t
            m13 += bx * hz_b + tx * hz_t
            m22 += by * hy_b + ty * hy_t
            m23 += by * hz_b + ty * hz_t
            m33 += bz * hz_b + tz * hz_t
            b1 -= bx * lb + tx * lt
            b2 -= by * lb + ty * lt
            b3 -= bz * lb + tz * lt
            bh, th = 0.0, 0.0
            if carrier >= 0:
                bh = lever_x * by - lever_y * bx
                th = lever_x * ty - lever_y * tx
                hinges[carrier + H_KX] += bh * hx_b + th * hx_t
                hinges[carrier + H_KY] += bh * hy_b + th * hy_t
                hinges[carrier + H_KZ] += bh * hz_b + th * hz_t
                hinges[carrier + H_D] += bh * (kbb * bh + kbt * th) + th * (kbt * bh + ktt * th)
                hinges[carrier + H_RHS] -= bh * lb + th * lt
            row[q + R_BX], row[q + R_BY], row[q + R_BZ], row[q + R_BH] = bx, by, bz, bh
            row[q + R_TX], row[q + R_TY], row[q + R_TZ], row[q + R_TH] = tx, ty, tz, th
            row[q + R_RHO_B], row[q + R_RHO_T] = rho_b, rho_t
            row[q + R_AB], row[q + R_BB], row[q + R_AT], row[q + R_BT] = ab, bb, at, bt
            row[q + R_P], row[q + R_Q] = p, inverse
            row[q + R_DECAY] = decay
            row[q + R_MOTOR] = motor0
            turn[t + T_TORQUE] = motor1
        b1 += fx
        b2 += fy
        b3 += fz
        for c in range(0, len(hinges), HINGE):  # eliminate the carriers
            d = 1.0 / hinges[c + H_D]
            hx, hy, hz = hinges[c + H_KX], hinges[c + H_KY], hinges[c + H_KZ]
            m11 -= hx * hx * d
            m12 -= hx * hy * d
            m13 -= hx * hz * d
            m22 -= hy * hy * d
            m23 -= hy * hz * d
            m33 -= hz * hz * d
            b1 -= hx * d * hinges[c + H_RHS]
            b2 -= hy * d * hinges[c + H_RHS]
            b3 -= hz * d * hinges[c + H_RHS]
        # symmetric positive definite 3x3: L D L^T
        l21 = m12 / m11
        l31 = m13 / m11
        d2 = m22 - l21 * m12
        l32 = (m23 - l31 * m12) / d2
        d3 = m33 - l31 * m13 - l32 * l32 * d2
        y2 = b2 - l21 * b1
        w1 = (b3 - l31 * b1 - l32 * y2) / d3
        vy1 = y2 / d2 - l32 * w1
        vx1 = b1 / m11 - l21 * vy1 - l31 * w1
        for c in range(0, len(hinges), HINGE):
            hinges[c + H_RATE] = (
                hinges[c + H_RHS] - hinges[c + H_KX] * vx1 - hinges[c + H_KY] * vy1
                - hinges[c + H_KZ] * w1) / hinges[c + H_D]
            hinges[c + H_ANGLE] += dt * (hinges[c + H_RATE] - w1)
        ground_x, ground_y, ground_mz = 0.0, 0.0, 0.0
        for i in range(count):
            t, q = i * TURN, i * ROW
            carrier = int(wheels[i * WHEEL + W_HINGE]) * HINGE
            spin = hinges[carrier + H_RATE] if carrier >= 0 else 0.0
            along = (row[q + R_BX] * vx1 + row[q + R_BY] * vy1 + row[q + R_BZ] * w1
                     + row[q + R_BH] * spin)
            side = (row[q + R_TX] * vx1 + row[q + R_TY] * vy1 + row[q + R_TZ] * w1
                    + row[q + R_TH] * spin)
            rho_b, rho_t = row[q + R_RHO_B], row[q + R_RHO_T]
            bb, bt = row[q + R_BB], row[q + R_BT]
            rate = (row[q + R_P] - rho_b * bb * along - rho_t * bt * side) * row[q + R_Q]
            slip_b = along + rho_b * rate
            slip_t = side + rho_t * rate
            force = -(row[q + R_AB] + bb * slip_b)
            force_side = -(row[q + R_AT] + bt * slip_t)
            fade = 1.0 / (1.0 + dt * row[q + R_DECAY])
            if turn[t + T_LOAD] > NO_LOAD:
                turn[t + T_SHEAR] = (turn[t + T_SHEAR] + dt * slip_b) * fade
                turn[t + T_SHEAR_SIDE] = (turn[t + T_SHEAR_SIDE] + dt * slip_t) * fade
            else:
                turn[t + T_SHEAR] = 0.0
                turn[t + T_SHEAR_SIDE] = 0.0
            turn[t + T_FORCE], turn[t + T_FORCE_SIDE] = force, force_side
            turn[t + T_SLIP], turn[t + T_SLIP_SIDE] = slip_b, slip_t
            turn[t + T_TORQUE] = row[q + R_MOTOR] - turn[t + T_TORQUE] * rate
            turn[t + T_RATE] = rate
            turn[t + T_ANGLE] += dt * rate
            turn[t + T_SLIP_RATE] = slip_b / rho_b
            turn[t + T_SLIP_ANGLE] += dt * slip_b / rho_b
            ground_x += row[q + R_BX] * force + row[q + R_TX] * force_side
            ground_y += row[q + R_BY] * force + row[q + R_TY] * force_side
            ground_mz += row[q + R_BZ] * force + row[q + R_TZ] * force_side
        lean(dt, body, state, lift_sum, roll_moment, pitch_moment, ground_x, ground_y,
             vx1 - vx0, vy1 - vy0, w1, w1 - yaw_rate, cosine, sine)
        state[S_VX] = cosine * vx1 - sine * vy1
        state[S_VY] = sine * vx1 + cosine * vy1
        state[S_W] = w1
        state[S_X] += dt * state[S_VX]
        state[S_Y] += dt * state[S_VY]
        state[S_YAW] += dt * w1
        state[S_BVX], state[S_BVY] = vx1, vy1
        state[S_GROUND_X], state[S_GROUND_Y] = ground_x, ground_y
        state[S_GROUND_MZ] = ground_mz
