#!/usr/bin/python3
"""The texts of the console's page: every language has those of English, with the same places to
fill in, and every text is used."""
import json
import pathlib
import re

PAGE = pathlib.Path(__file__).resolve().parent.parent.parent / "services/console/page"
LANGUAGES = {"en", "de", "es", "pl", "zh"}


def places(pattern):
    """Of each form that a count may have: "one: ... | other: ..."."""
    forms = {tuple(sorted(re.findall(r"\{\w+\}", form))) for form in pattern.split(" | ")}
    assert len(forms) == 1, pattern
    return forms.pop()


def main():
    catalogues = {file.stem: json.loads(file.read_text(encoding="utf-8"))
                  for file in (PAGE / "texts").glob("*.json")}
    assert set(catalogues) == LANGUAGES, sorted(catalogues)
    english = catalogues["en"]
    for language, texts in catalogues.items():
        assert list(texts) == list(english), (language, set(texts) ^ set(english))
        for name, pattern in texts.items():
            assert pattern.strip() == pattern != "", (language, name)
            assert places(pattern) == places(english[name]), (language, name, pattern)
        own = sum(texts[name] != english[name] for name in english)
        assert language == "en" or own > len(english) * 3 // 4, f"{language}: {own} are its own"
    source = "".join(file.read_text(encoding="utf-8")
                     for file in [*PAGE.glob("*.ts"), *PAGE.glob("*.html")])
    used = set(re.findall(r"text\.(\w+)", source)) | set(re.findall(r'data-text="(\w+)"', source))
    used |= {"operator", "observer"}  # by the role of the session
    families = tuple(re.findall(r"text\[`(\w+_)\$\{", source))  # `method_${method}`
    used |= {name for name in english if name.startswith(families)}
    assert set(english) <= used, f"not used: {set(english) - used}"
    # A text that a person reads, written into the source, has no translation.
    written = re.findall(r"make\('[a-z]+', ['`]([A-Za-z][^'`]*)['`]", source)
    assert not written, written


if __name__ == "__main__":
    main()
