"""Messages that name arguments of functions, with the options that give these when typed."""

from __future__ import annotations

import re
from collections.abc import Collection

# A message about `sampling`, which commands split into several options.
_SAMPLING = re.compile(r"sampling: expected omma\.Fixed for (.+), found (ToError|Shared)\(.*")
# The subject of a message: one argument or several, at its beginning or after a file name.
_SUBJECT = re.compile(r"(?:^|(?<=: ))\w+(?:(?:, | and )\w+)*(?=: )")
# What is said of --light is in its own words, some of which are called as options are.
_WORDS_OF_LIGHT = re.compile(r"(?:^|(?<=: ))light: .*", re.DOTALL)
# An argument with a value: name=value.
_SAID = re.compile(r"\b([a-z_]+)=(?:\"([^\"]*)\"|'([^']*)'|([\d.]*\d)|(True))")
# What is to be written in Python stays as it is: calls, with calls among their arguments.
_CALL = re.compile(r"\bomma(?:\.\w+)+\((?:[^()]|\([^()]*\))*\)")
_STAND_IN = "\x1a"  # in no message, of which Error escapes such characters
# Arguments inside a message: only names with an underscore, as others are ordinary words.
_OF_TWO_WORDS = re.compile(r"(?<![\w./=-])[a-z]+(?:_[a-z]+)+(?![\w./=-])")


def as_typed(message: str, options: Collection[str]) -> str:
    """The message with options of a command, of which these are all, instead of arguments."""

    def option_of(name: str) -> str:
        option = "--" + name.replace("_", "-")
        one_of_several = option.removesuffix("s")  # that can be given several times
        return next((one for one in (option, one_of_several) if one in options), name)

    def options_of(found: re.Match[str]) -> str:
        return re.sub(r"(?!and\b)\b\w+", lambda name: option_of(name[0]), found[0])

    def option_said(found: re.Match[str]) -> str:
        name, *values, is_true = found.groups()
        option = option_of(name)
        if option == name:
            return found[0]
        return option if is_true else f"{option} {next(filter(None, values))}"

    def sampling_said(found: re.Match[str]) -> str:
        option = "--error" if found[2] == "ToError" else "--shared"
        return f"{option}: not for {found[1]}, where --samples says how many rays there are"

    if "--light" in options and (of_light := _WORDS_OF_LIGHT.search(message)):
        # A name of a file may stand before it.
        return f"{message[: of_light.start()]}--{of_light[0]}"
    message = _SAMPLING.sub(sampling_said, message)
    calls = _CALL.findall(message)
    message = _SUBJECT.sub(options_of, _CALL.sub(_STAND_IN, message), count=1)
    message = _OF_TWO_WORDS.sub(lambda name: option_of(name[0]), _SAID.sub(option_said, message))
    for call in calls:
        message = message.replace(_STAND_IN, call, 1)
    return message
