import pytest

from mecanum_base.cli.main import main
from mecanum_base.cli.verbs import VERBS


def test_without_a_command_the_overview_is_shown_and_the_usage_is_wrong(capsys):
    assert main([]) == 2
    shown = capsys.readouterr().out
    assert all(f'  {verb}' in shown for verb in VERBS)


def test_the_version_is_that_of_the_package(capsys):
    assert main(['--version']) == 0
    assert capsys.readouterr().out == 'mecanum_base 0.1.0\n'


def test_an_unknown_command_is_named_in_one_line(capsys):
    assert main(['replai']) == 2
    shown = capsys.readouterr()
    assert shown.out == ''
    assert shown.err.startswith("mecanum: unknown command 'replai'")
    assert shown.err.count('\n') == 1


@pytest.mark.parametrize('verb', VERBS)
def test_every_command_has_help_with_an_example(verb, capsys):
    with pytest.raises(SystemExit) as end:
        main([verb, '--help'])
    assert end.value.code == 0
    shown = capsys.readouterr().out
    assert 'example:' in shown
    assert f'mecanum {verb}' in shown.split('example:')[1]


@pytest.mark.parametrize('words', [['replay', 'no_such.mcap', '--robot', 'no_such.yaml',
                                    '--out', 'x'], ['check', 'no_such.yaml']])
def test_missing_input_is_one_line_and_exit_code_2(words, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(words) == 2
    error = capsys.readouterr().err
    assert error.startswith(f'mecanum {words[0]}: ')
    assert 'no_such' in error
    assert error.count('\n') == 1
