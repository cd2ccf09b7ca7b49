"""The `mecanum` command: Ctrl-C ends it without a word until a verb runs.

Nothing is imported before that is arranged: numpy and the like take a tenth of a second to load,
in which an interrupt would print a traceback, or be lost in a callback of the import itself.
"""

TYPE_CHECKING = False  # as in typing, which would have to be loaded
if TYPE_CHECKING:
    from collections.abc import Sequence

INTERRUPTED = 130  # 128 + SIGINT, as shells count


def main(arguments: 'Sequence[str] | None' = None) -> int:
    """Run one verb, without ``arguments`` that of the command line; returns the exit code."""
    try:
        if arguments is None:
            from mecanum_base.cli.beginning import interrupts_end_it
            interrupts_end_it(INTERRUPTED)
        from mecanum_base.cli.verbs import run
        return run(arguments)
    except KeyboardInterrupt:
        return INTERRUPTED
