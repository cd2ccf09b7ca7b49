"""One encoder frame: judge all wheels together, then correct the state.

Measurement of wheel i is its travel z_i, residual r = z - phi, covariance S0 = P_phiphi + R:

    R = diag(resolution^2) + tj^2 w w'      w = travel per second of each wheel, tj = stamp jitter

Each hypothesis m says which wheels slip and how alike: S_m = S0 + T^2 (A D A' + V_m) with a finite
prior V_m of slip speeds (T = time since the last frame) and the doubt D of the velocity
(:mod:`.doubt`). One more says that the frame's stamp is late.
Posterior by Bayes over all hypotheses at once; the update then treats a slipping wheel as knowing
nothing (slip speed sigma 3 m/s), and mixes the hypotheses by moments:

    D_m = C + E U_m,  W_m = (S0 + U_m)^-1,  d_m = D_m W_m r,   C = P[:, phi], E selects phi
    x <- x + sum p_m d_m
    P <- P + sum p_m (E U_m E' - D_m W_m D_m' + d_m d_m') - d d'

The two priors must not be mixed up: a finite one in the update would leak slip into the velocity.
"""

from __future__ import annotations

import math

import numpy as np

from mecanum_base.core.estimation.acceleration import kernel, part
from mecanum_base.core.estimation.doubt import admit, doubted_travel
from mecanum_base.core.estimation.layout import (
    ALL_SLID,
    CREEPS,
    EXTRA,
    FLAT,
    FORCED,
    GRIP_NIS,
    JITTER,
    KICK,
    KL,
    LATE,
    LATE_RUN,
    LEAN_GAIN,
    LOCKED_FOR,
    LOOSE_FOR,
    PENDING_T,
    PROBABILITY,
    REACH,
    SIGMA,
    SLIP,
    VX,
    VY,
    WZ,
    K,
    Memory,
)
from mecanum_base.core.estimation.model import Model
from mecanum_base.core.estimation.obstacle import perhaps_held
from mecanum_base.core.parameter import FloatArray

NEGLIGIBLE = 0.03  # a hypothesis this improbable moves nothing: doubt repeated is no evidence
CALM = 2.0  # standard deviations of a residual that is not worth a covariance step
SURE = 0.99  # probability of grip above which the short path is taken
LATE_SIGMA = 0.006  # s, size of a late stamp
HELD_FACTOR = 1e-3  # for gripping again while something holds the base and slip stays the same
FOLLOWED = 0.5  # gain of the gyro's x and y axes above which a tilting floor is no slow slip
MISSING = 1.0  # m^2, variance that stands for a wheel without a reading


@part
def rolling_speed(memory: Memory, wheels: int) -> FloatArray:
    """Travel per second (W,) m/s of each wheel if it rolls with the present twist."""
    x = memory.x
    side = K + 3 * wheels
    twist = np.array([float(x[VX]), float(x[VY]), (1.0 + float(x[KL])) * float(memory.m[WZ])])
    lateral = memory.rows[:, 1] * x[side:side + wheels] * float(x[VY])
    speed: FloatArray = (1.0 + x[K:K + wheels]) * (memory.rows @ twist + lateral)
    return speed


@kernel
def log_likelihood(S: FloatArray, r: FloatArray) -> FloatArray:
    """log N(r; 0, S[:, :, m]) + const for each m: Cholesky of all (W, W, M) matrices at once."""
    w, count = S.shape[0], S.shape[2]
    L = np.zeros((w, w, count))
    y = np.zeros((w, count))
    total = np.zeros(count)
    for j in range(w):
        pivot = S[j, j].copy()
        for k in range(j):
            pivot -= L[j, k] * L[j, k]
        root = np.sqrt(np.maximum(pivot, 1e-18))
        L[j, j] = root
        for i in range(j + 1, w):
            entry = S[i, j].copy()
            for k in range(j):
                entry -= L[i, k] * L[j, k]
            L[i, j] = entry / root
        rest = np.full(count, r[j])
        for k in range(j):
            rest -= L[j, k] * y[k]
        y[j] = rest / root
        total -= 0.5 * y[j] * y[j] + np.log(root)
    return total


@part
def correct(memory: Memory, wheels: int, r: FloatArray, S: FloatArray, inverse: FloatArray,
            loose: bool) -> None:
    """Plain update by all wheels; ``inverse`` of S; ``loose``: some travel has extra variance."""
    phi, creep = K + wheels, K + 2 * wheels
    P = memory.P
    D = P[:, phi:creep].copy()
    if loose:
        full = S.copy()
        for i in range(wheels):
            extra = memory.each[EXTRA, i]
            D[phi + i, i] += extra
            full[i, i] += extra
            P[phi + i, phi + i] += extra
        inverse = np.linalg.inv(full)
    gain = D @ inverse
    memory.x[:] += gain @ r
    P -= gain @ D.T
    P[:, :] = 0.5 * (P + P.T)


@kernel
def mix(model: Model, memory: Memory, r: FloatArray, S: FloatArray, p: FloatArray, T: float,
        late: float, late_cov: FloatArray) -> None:
    """Moment-matched update by all hypotheses; ``late`` is the probability of a late stamp."""
    w = model.wheels
    phi, creep, n = K + w, K + 2 * w, K + 4 * w
    loose = (model.loose_sigma * T) ** 2
    extra = memory.wheel[EXTRA]
    C = np.ascontiguousarray(memory.P[:, phi:creep])
    total = 0.0
    for m in range(len(p)):
        if p[m] > NEGLIGIBLE:
            total += p[m]
    if late > NEGLIGIBLE:
        total += late
    dx = np.zeros(n)
    dP = np.zeros((n, n))
    for m in range(len(p) + 1):
        weight = late if m == len(p) else p[m]
        if not weight > NEGLIGIBLE:  # nor where it is no number: then the filter starts anew
            continue
        weight = weight / total
        D = C.copy()
        full = S.copy()
        if m == len(p):
            full += late_cov
        for i in range(w):
            slips = 0.0 if m == len(p) else model.member[m, i]
            u = slips * loose + (1.0 - slips) * extra[i]
            D[phi + i, i] += u
            full[i, i] += u
            dP[phi + i, phi + i] += weight * u
        gain = D @ np.linalg.inv(full)
        d = gain @ r
        dx += weight * d
        dP += weight * (np.outer(d, d) - gain @ D.T)
    memory.x[:] += dx
    P = memory.P + dP - np.outer(dx, dx)
    memory.P[:, :] = 0.5 * (P + P.T)


@kernel
def foresee(model: Model, memory: Memory, T: float) -> FloatArray:
    """Probabilities (M,) of the hypotheses before the frame is seen.

    Where only the IMU knows the velocity along a slip, its error is the same in the next frame:
    frame for frame the same doubt would add up to a grip. It is counted here once, as
    exp(-(slip^2/sigma^2 - 1)/2). For a diagonal only where its slip has not changed at once by
    more than is left of it, as it does when wheels grip, and where tilt is followed
    (:mod:`.lean`): else every ramp looks like slow slip.
    """
    p = memory.mode
    step = min(T, 0.1)
    prior = p + step * (p @ model.change)
    stands = perhaps_held(memory)
    everything = memory.wheel[PROBABILITY].min() > 0.5
    by_imu = (memory.m[LOCKED_FOR] > 0.0 and memory.m[ALL_SLID] == 0.0
              and memory.m[LEAN_GAIN] > FOLLOWED)
    for i in range(model.wheels):
        factor = 1.0
        if memory.each[PROBABILITY, i] > 0.5:
            if memory.each[FLAT, i] == 0.0:
                factor = model.regrip_factor
            if stands:
                factor *= HELD_FACTOR
            if everything or (by_imu and memory.m[KICK] < abs(memory.each[SLIP, i])):
                off = memory.each[SLIP, i] / memory.each[SIGMA, i]
                factor *= math.exp(-0.5 * min(max(off * off - 1.0, 0.0), 40.0))
        limit = model.creep_limit if memory.each[PROBABILITY, i] > 0.5 else memory.m[CREEPS]
        over = abs(float(memory.wheel[SLIP, i])) - limit
        if over > 0.0:  # no wheel creeps this fast and still grips
            over /= max(model.creep_edge, float(memory.wheel[SIGMA, i]))
            factor *= math.exp(-0.5 * min(over * over, 40.0))
        if memory.wheel[FORCED, i] > 0.0:
            factor = 1e-12
        if factor < 1.0:
            for m in range(len(p)):
                if model.member[m, i] == 0.0:
                    prior[m] *= factor
    prior = np.maximum(prior, 1e-30)
    prior /= prior.sum()
    return prior


@part
def judge(model: Model, memory: Memory, z: FloatArray, valid: FloatArray, T: float) -> bool:
    """Use the travel z (W,) of one frame, ``valid`` 1 where it is known; True on the short path.

    T [s] is the time since the last frame. Sets the probabilities of memory.wheel.
    """
    w = model.wheels
    m = memory.m
    phi, creep = K + w, K + 2 * w
    s, each = memory.s, memory.each
    speed = rolling_speed(memory, w)
    grip = memory.P[phi:creep, phi:creep] + model.reading
    tj = m[JITTER]
    S = grip + (tj * speed).reshape(w, 1) * speed
    r = np.empty(w)
    creeps = forced = loose = False
    for i in range(w):
        r[i] = (z[i] - s[phi + i]) * valid[i]
        if valid[i] == 0.0:
            S[i, i] += MISSING
        each[REACH, i] = CALM * math.sqrt(max(S[i, i], 0.0))
        creeps = creeps or abs(each[SLIP, i]) > m[CREEPS]
        forced = forced or each[FORCED, i] > 0.0
        loose = loose or each[EXTRA, i] > 0.0
    inverse = np.linalg.inv(S)
    nis = float(r @ (inverse @ r))
    m[GRIP_NIS] = nis
    short = memory.mode[0] > SURE and nis < 2.25 * w and not creeps and not forced
    late = 0.0
    if short:
        correct(memory, w, r, S, inverse, loose)
        grips = 1.0
        memory.mode[:] = 0.0
        memory.mode[0] = 1.0
        memory.wheel[PROBABILITY] = 0.0
    else:
        count = len(memory.mode)
        prior = foresee(model, memory, T)
        stack = np.empty((w, w, count + 1))
        late_cov = (LATE_SIGMA ** 2 * speed).reshape(w, 1) * speed
        # where the frames before counted as late, slip may have lasted all that time
        whole = T + m[PENDING_T]
        doubted = S + doubted_travel(memory, whole)
        stack[:, :, :count] = doubted.reshape(w, w, 1) + (whole * whole) * model.likely
        stack[:, :, count] = doubted + late_cov
        score = log_likelihood(stack, r)
        # frames held up together come in twos; three in a row are no lateness
        lag = model.late_weight / (1.0 + float(m[LATE_RUN]) ** 10)
        if forced:
            lag = 0.0
        score[:count] += np.log(prior * (1.0 - lag))
        score[count] += math.log(lag * prior[0] + 1e-30)
        score = np.exp(score - score.max())
        score /= score.sum()
        late = float(score[count])
        p = score[:count].copy()
        if admit(model, memory, p @ model.member):
            S += memory.P[phi:creep, phi:creep] + model.reading - grip
        mix(model, memory, r, S, p, whole, late, late_cov)
        p[0] += late
        memory.mode[:] = p
        grips = float(p[0])
        memory.wheel[PROBABILITY] = p @ model.member
    if loose:
        memory.wheel[EXTRA] = 0.0
    m[LATE] = late
    m[LATE_RUN] = late * (1.0 + m[LATE_RUN])
    m[LOOSE_FOR] = model.extra_time if grips < 0.7 else max(0.0, m[LOOSE_FOR] - T)
    power = float(speed @ speed)
    if grips > 0.95 and late < 0.5 and power > 0.02:
        rho = float(speed @ r) / power
        known = float(speed @ (grip @ speed))
        seen = min(rho * rho - known / (power * power), 9.0 * tj)
        m[JITTER] = min(25e-6, max(4e-8, tj + 0.02 * (seen - tj)))
    return short
