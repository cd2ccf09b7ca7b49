"""Every error this package raises on purpose.

    MecanumBaseError
    ├── ConfigError      a robot or scenario file breaks a rule: key path, value, rule, unit
    │   └── GeometryError   the wheels cannot carry the base: the free self-motion is named
    └── BagError         a recording cannot be read: which file, where, why

Data never raises: a bad sample is rejected, counted and named in the health of the estimate.
"""

from __future__ import annotations


class MecanumBaseError(Exception):
    """Root of all errors raised on purpose; its text is one line a user can act on."""


class ConfigError(MecanumBaseError):
    """A configured value breaks a rule.

    ``key`` is the path of the value (``wheels.radius[2]``), ``value`` what was found, ``rule``
    what was expected, ``unit`` the unit of the value ('' where it has none).
    """

    def __init__(self, key: str, value: object, rule: str, unit: str = '') -> None:
        self.key, self.value, self.rule, self.unit = key, value, rule, unit
        shown = '' if value is _ABSENT or value is None else f' = {value!r}'
        super().__init__(f'{key}{shown}: {rule}' + (f' [{unit}]' if unit else ''))

    def __reduce__(self) -> tuple[type[ConfigError], tuple[str, object, str, str]]:
        """Pickled whole: errors cross from worker processes."""
        return type(self), (self.key, self.value, self.rule, self.unit)

    @classmethod
    def missing(cls, key: str, meaning: str, unit: str = '') -> ConfigError:
        """The error for a value that must be given and is not."""
        return cls(key, _ABSENT, f'is missing and has no default: {meaning}', unit)

    def under(self, prefix: str) -> ConfigError:
        """The same error with its key path moved below ``prefix``."""
        moved = type(self)(f'{prefix}.{self.key}' if self.key else prefix, self.value,
                           self.rule, self.unit)
        return moved

    def located(self, place: str) -> ConfigError:
        """The same error with the place of its key (file and line) put before the key path."""
        return type(self)(f'{place}, {self.key}', self.value, self.rule, self.unit)


class GeometryError(ConfigError):
    """The wheel set leaves a motion that no wheel resists (Gfrerrer, Theorem 2)."""


class BagError(MecanumBaseError):
    """A recording cannot be used: names the file and the reason."""


class _Absent:
    def __repr__(self) -> str:
        return '<absent>'


_ABSENT = _Absent()
