"""The schema of `report.json` as a document: docs/reference/report_schema.md is made from it."""

from collections.abc import Iterator, Mapping

from cdp_ident.configuration.keys import WEIGHTS
from cdp_ident.report.schema import REPORT
from cdp_ident.report.schema_terms import Schema


def outline(schema: Schema = REPORT, name: str = "") -> Iterator[tuple[str, str, str]]:
    """Yield name, type and description of everything that a report may hold, for its documentation."""
    schema, *_ = schema.get("anyOf", [schema])  # the other is null
    inside = {f"{name}.{keys}".lstrip("."): value for keys, value in _alike(schema.get("properties", {}))}
    inside |= {f"{name}.{WEIGHTS}*": value for value in schema.get("patternProperties", {}).values()}
    if schema.get("additionalProperties"):
        inside[f"{name}.*"] = schema["additionalProperties"]
    if "items" in schema:
        inside[f"{name}[]"] = schema["items"]
    for key, value in inside.items():
        yield key, _type(value), value.get("description", "")
        yield from outline(value, key)


def document() -> str:
    """Return the text of docs/reference/report_schema.md."""
    rows = "".join(f"| `{name}` | {kind} | {about} |\n" for name, kind, about in outline())
    return _HEAD + rows


_HEAD = """\
# The schema of report.json

Strict JSON. `number or null`: null stands for a number that is not finite. `[]` is each element of a list, `.*` each
value of an object with names of its own, `a/b` two keys that hold alike things. Lists, texts and numbers have
limits, and nothing else may be there: `report` and `compare` refuse what contradicts this. The statement itself, a
JSON Schema, is `REPORT` in `cdp_ident/report/schema.py`.

| key | type | meaning |
|---|---|---|
"""


def _alike(properties: Mapping[str, Schema]) -> Iterator[tuple[str, Schema]]:
    """Yield what an object holds; keys whose values are alike, and are objects themselves, together."""
    for key, value in properties.items():
        keys = [other for other, schema in properties.items() if schema == value and "properties" in value]
        if not keys or key == keys[0]:
            yield "/".join(keys or [key]), value


def _type(schema: Schema) -> str:
    if "enum" in schema:
        words = [f"`{word}`" if word else "empty" for word in schema["enum"]]
        return " or ".join(words) if len(words) <= 4 else f"one of {len(words)} words"
    if "anyOf" in schema:
        return " or ".join(_type(inner) for inner in schema["anyOf"])
    kind = schema.get("type", "")
    return " or ".join(kind) if isinstance(kind, list) else str(kind)
