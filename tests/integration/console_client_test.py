#!/usr/bin/python3
"""The client of python3-intaglio against docs/openapi.json: it has the requests that are there
and no others, sends the fields of their bodies, reads only fields of their answers, and names
the message that each method returns.

  console_client_test.py --schemas build/release/docs/schemas --folder FOLDER
"""
import argparse
import inspect
import io
import json
import pathlib
import shutil
import sys
import typing

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "deploy/python"))
import intaglio_console  # noqa: E402

# What each method is called with; the names of files and jobs are those of the paths.
ARGUMENTS = {
    "log_in": ("anna", "secret"),
    "teaching": ("{cell}",),
    "add_photo": ("{job}", "{file}"),
    "submit_pulse": ("{cell}", "{id}", (50, 50, 30)),
    "submit_focus_series": ("{cell}", "{id}", (50, 50, 30)),
    "series_zero_move": ("{cell}", "{job}", 12),
    "upload": ("{id}", "{file}"),
    "submit": ("{id}", "{file}"),
    "preview": ("{id}", "{file}"),
    "preview_picture": ("{id}",),
    "arm": ("{job}", "block"),
    "resume": ("{job}", "block"),
    "set_speed": ("{job}", 50),
    "move": ("{job}", ""),
    "reset": ("{cell}", ["intaglio-stop (number 1)"]),
}
OF_A_JOB = ("job", "follow", "pause", "cancel", "report", "picture", "views", "plan", "made",
            "ticks", "channels", "photo")
PACKED = {"plan": b"INTPLAN2" + bytes(16 + 4 * 513), "made": bytes(4),
          "ticks": bytes(4)}


class Described:
    """docs/openapi.json and the schemas that it names."""

    def __init__(self, schemas):
        self.paths = json.loads((ROOT / "docs/openapi.json").read_text())["paths"]
        self.schemas = schemas

    def requests(self):
        return {(method.upper(), path) for path, operations in self.paths.items()
                for method in operations if method in ("get", "post")}

    def operation(self, method, path):
        return self.paths[path][method.lower()]

    def _schema(self, content):
        reference = content.get("application/json", {}).get("schema", {}).get("$ref")
        return reference and json.loads((self.schemas.parent / reference).read_text())

    def body_fields(self, method, path):
        content = self.operation(method, path).get("requestBody", {}).get("content", {})
        schema = self._schema(content)
        return set(self._resolved(schema, schema).get("properties", {})) if schema else set()

    def returned(self, method, path):
        return self.operation(method, path)["responses"]["200"]["description"]

    def answer(self, method, path):
        """An answer with every field that its schema has."""
        content = self.operation(method, path)["responses"]["200"]["content"]
        schema = self._schema(content)
        return self._example(schema, schema) if schema else None

    def _resolved(self, whole, schema):
        while "$ref" in schema:
            part = whole
            for name in schema["$ref"].lstrip("#/").split("/"):
                part = part[name]
            schema = part
        return schema

    def _example(self, whole, schema, depth=0):
        schema = self._resolved(whole, schema)
        if "enum" in schema:
            return "done" if "done" in schema["enum"] else schema["enum"][0]
        if "properties" in schema and depth < 4:
            return {name: self._example(whole, field, depth + 1)
                    for name, field in schema["properties"].items()}
        if "oneOf" in schema:  # a number, or one that JSON has no number for
            return self._example(whole, schema["oneOf"][0], depth)
        kind = schema.get("type")
        return {"boolean": True, "integer": 0, "number": 0, "string": "done",
                "array": []}.get(kind[0] if isinstance(kind, list) else kind, {})


class Recorded(intaglio_console.Console):
    """A client whose requests are kept, and answered by what the schemas say."""

    def __init__(self, described):
        super().__init__("http://127.0.0.1:1/?key=k")
        self.described = described
        self.requests = []

    def _open(self, method, path, body=None, **query):
        self.requests.append((method, path, body))
        assert (method, path) in self.described.requests(), f"unknown: {method} {path}"
        answer = self.described.answer(method, path)
        if answer is None:
            return io.BytesIO(PACKED.get(path.rsplit("/", 1)[-1], b""))
        return io.BytesIO(json.dumps(answer).encode())


def public_methods():
    return {name: method for name, method in inspect.getmembers(intaglio_console.Console)
            if inspect.isfunction(method) and not name.startswith("_")}


def check_annotations():
    """Every function has the types of its parameters and of its result."""
    functions = list(inspect.getmembers(intaglio_console.Console, inspect.isfunction))
    functions += inspect.getmembers(intaglio_console.Refused, inspect.isfunction)
    functions += inspect.getmembers(intaglio_console, inspect.isfunction)
    for name, function in functions:
        if function.__module__ != intaglio_console.__name__:
            continue
        hints = typing.get_type_hints(function)
        missing = {"return", *inspect.signature(function).parameters} - {"self"} - set(hints)
        assert not missing, f"{name}: no type of {missing}"
    for name, method in public_methods().items():
        assert inspect.getdoc(method), f"{name}: no documentation"


def is_of_files(path):
    """The body is no message."""
    return "/submissions/" in path or "/photos/" in path


def check_requests(described):
    sent = {}
    for name in public_methods():
        console = Recorded(described)
        arguments = ARGUMENTS.get(name, ("{job}",) if name in OF_A_JOB else ())
        result = getattr(console, name)(*arguments)
        if inspect.isgenerator(result):
            list(result)
        method, path, _ = console.requests[-1]
        message = described.returned(method, path)
        if "/" not in message:
            documented = inspect.getdoc(public_methods()[name])
            assert message in documented, f"{name}: its documentation does not name {message}"
        if message == "image/png":
            assert "PNG" in inspect.getdoc(public_methods()[name]), name
        for method, path, body in console.requests:
            fields = sent.setdefault((method, path), set())
            if method == "POST" and not is_of_files(path):
                fields |= set(json.loads(body))
    unsent = described.requests() - set(sent)
    assert not unsent, f"no method sends {unsent}"
    for (method, path), fields in sent.items():
        if is_of_files(path):
            continue
        wanted = described.body_fields(method, path)
        assert fields == wanted, f"{method} {path}: sends {fields}, the schema has {wanted}"
    return len(sent)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--schemas", required=True, type=pathlib.Path)
    parser.add_argument("--folder", required=True, type=pathlib.Path)
    given = parser.parse_args()
    shutil.rmtree(given.folder, ignore_errors=True)
    given.folder.mkdir(parents=True)
    file = given.folder / "{file}"
    file.write_text("solid nothing")
    for name, arguments in ARGUMENTS.items():
        ARGUMENTS[name] = tuple(file if word == "{file}" else word for word in arguments)
    check_annotations()
    print(check_requests(Described(given.schemas)), "requests as docs/openapi.json has them")


if __name__ == "__main__":
    main()
