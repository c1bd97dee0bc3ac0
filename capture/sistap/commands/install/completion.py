# SPDX-License-Identifier: GPL-2.0-or-later
"""Completion for bash and zsh, made from the parser of all commands, so that it has every option.

Both scripts are static: pressing Tab starts no Python.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator

from sisbus.library import names

_FILES = {"FILE", "CAPTURE", "LOG", "OUT", "PIPE"}  # metavars
_HELP = ("-h", "--help")

_BASH = """\
# Completion of sistap for bash, made by sistap from its own options.
_sistap_ports() {
    compgen -G '/dev/ttyUSB*'
    compgen -G '/dev/ttyACM*'
    compgen -G '/dev/ttyS[0-9]*'
    compgen -G '/dev/cu.*'
}

_sistap() {
    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} words
    if [ "$word" = = ]; then # --option=
        word=
    elif [ "$before" = = ]; then
        before=${COMP_WORDS[COMP_CWORD - 2]}
    fi
    if [ "$COMP_CWORD" -eq 1 ]; then
        words='@COMMANDS@'
    else
        case "${COMP_WORDS[1]} $before" in
@VALUES@
        *)
            case "${COMP_WORDS[1]} $word" in
@OPTIONS@
            esac
            ;;
        esac
    fi
    COMPREPLY=($(compgen -W "$words" -- "$word")) # macOS's bash has no mapfile
}

# Where it has no words, names of files.
complete -o bashdefault -o default -F _sistap sistap
"""

_ZSH = """\
#compdef sistap
# Completion of sistap for zsh, made by sistap from its own options.
_sistap_ports() {
    local -a ports=(/dev/ttyUSB*(N) /dev/ttyACM*(N) /dev/ttyS<->(N) /dev/cu.*(N))
    _alternative 'ports:port:compadd -a ports' 'files:file:_files'
}

_sistap_scenarios() {
    _alternative 'scenarios:scenario:(@SCENARIOS@)' 'files:file:_files'
}

_sistap() {
    local context state state_descr line
    local -A opt_args
    local -a commands=(
@COMMANDS@
    )
    _arguments -C \\
@WHOLE@
        '1:command:->command' '*::argument:->argument' && return
    case $state in
    command) _describe command commands ;;
    argument)
        case $line[1] in
@CASES@
        esac
        ;;
    esac
}

_sistap "$@"
"""


def bash(whole: argparse.ArgumentParser) -> str:
    """Return the script for bash; `whole` is the parser with the options of all commands."""
    values, options = [], []
    for name, command in _commands(whole).items():
        for action in _shown(command):
            words = _ports_or_words(action)
            for option in action.option_strings if _takes_value(action) else ():
                values.append(f"        '{name} {option}') words={words} ;;")
        called = " ".join(option for action in _shown(command) for option in action.option_strings)
        options.append(f"            '{name} -'*) words='{called}' ;;")
        options += [
            f"            '{name} '*) words={words} ;;"
            for action in _shown(command)
            if not action.option_strings and (words := _ports_or_words(action)) != "''"
        ]
    commands = [*_commands(whole), *(option for action in whole._actions for option in action.option_strings)]
    return _filled(_BASH, COMMANDS=" ".join(commands), VALUES="\n".join(values), OPTIONS="\n".join(options))


def zsh(whole: argparse.ArgumentParser) -> str:
    """Return the script for zsh; `whole` is the parser with the options of all commands."""
    described = {action.dest: action.help or "" for action in _choices(whole)._choices_actions}
    cases = []
    for name, command in _commands(whole).items():
        cases.append(f"        {name})\n            _arguments -s \\")
        cases.append(" \\\n".join(f"                {line}" for line in _specifications(command)) + " ;;")
    return _filled(
        _ZSH,
        COMMANDS="\n".join(f"        {_quoted(f'{name}:{text}')}" for name, text in described.items()),
        WHOLE="\n".join(f"        {line} \\" for line in _specifications(whole)),
        CASES="\n".join(cases),
        SCENARIOS=" ".join(names()),
    )


def _filled(template: str, **parts: str) -> str:
    for name, text in parts.items():
        template = template.replace(f"@{name}@", text)
    return template


def _shown(command: argparse.ArgumentParser) -> list[argparse.Action]:
    """Return the options and arguments of a command that its help shows."""
    return [action for action in command._actions if action.help != argparse.SUPPRESS]


def _choices(whole: argparse.ArgumentParser) -> argparse._SubParsersAction[argparse.ArgumentParser]:
    return next(action for action in whole._actions if isinstance(action, argparse._SubParsersAction))


def _commands(whole: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    return dict(_choices(whole).choices)


def _takes_value(action: argparse.Action) -> bool:
    return action.nargs != 0


def _words(action: argparse.Action) -> list[str]:
    """Return the possible words of an option or argument, where they can be listed."""
    if action.choices is not None:
        return [str(choice) for choice in action.choices]
    metavar = str(action.metavar or "")
    if metavar == "SCENARIO":
        return names()
    return [part for part in metavar.split("|") if re.fullmatch("[a-z0-9]+", part)]  # as in RATE|auto


def _ports_or_words(action: argparse.Action) -> str:
    return '"$(_sistap_ports)"' if action.metavar == "PORT" else f"'{' '.join(_words(action))}'"


def _specifications(command: argparse.ArgumentParser) -> Iterator[str]:
    """Yield what _arguments of zsh needs for each option and argument."""
    for action in _shown(command):
        text = re.sub(r"([\[\]:\\])", r"\\\1", (action.help or "") % _Expanded(vars(action)))
        name = str(action.metavar or action.dest).replace("|", " or ").replace(":", r"\:")
        value = f":{name}:{_completer(action)}"
        if isinstance(action, argparse._SubParsersAction):
            continue
        if not action.option_strings:
            yield _quoted(f"{'*' if action.nargs in ('*', '+') else ''}:{value.lstrip(':')}")
        for option in action.option_strings:
            first = "(- *)" if option in _HELP else "*"  # some can be given several times
            joined = "=" if _takes_value(action) and option.startswith("--") else ""  # also --option=value
            yield _quoted(f"{first}{option}{joined}[{text}]{value if _takes_value(action) else ''}")


class _Expanded(dict[str, object]):
    """The names that a help text can use as %(name)s."""

    def __missing__(self, name: str) -> str:
        return ""


def _completer(action: argparse.Action) -> str:
    if action.metavar in ("PORT", "SCENARIO"):
        return f"_sistap_{str(action.metavar).lower()}s"
    if words := _words(action):
        return f"({' '.join(words)})"
    return "_files" if action.metavar in _FILES else " "


def _quoted(text: str) -> str:
    return "'" + text.replace("'", "'\\''") + "'"
