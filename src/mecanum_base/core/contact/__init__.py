"""Exact contact kinematics: the contact point wanders along each roller (G eq. 10-15).

How much it matters, wheel of 50 mm radius, pin radius 38 mm, 45 degrees, base 400 x 300 mm
(tests/core/contact/test_size_of_the_effect.py measures every number):

    rollers k                    6       8       9       10      12      15
    lateral ripple, peak [%]     15.5    8.24    6.42    5.15    3.53    2.23
    lateral over-read [%]        4.72    2.62    2.06    1.66    1.15    0.73
    yaw sawtooth +- [%]          6.3     4.5     4.0     3.5     2.9     2.3
    contact travel [mm]          43.9    31.5    27.7    24.7    20.4    16.2

Driving forward has neither ripple nor error, for any wheel. Driven sideways, k = 9, nominal
odometry over-reads 21 mm a metre; with the mean correction of
:func:`mecanum_base.core.kinematics.matrix.effective_roller` the error is below 0.1 % (1 mm), and
with known roller phases (:mod:`mecanum_base.core.contact.odometry`) only forced slip is left.
Swedish wheels (roller at 90 degrees) have none of it.
"""
