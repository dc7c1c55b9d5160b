"""Settings that several node types share, declared as one group."""

import dataclasses
import inspect
from collections.abc import Callable
from functools import wraps
from typing import Any, get_type_hints


def flat_group(name: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Declare the fields of a keyword-only group as settings of the node; used below `@node`.

    name  of the parameter, annotated with a frozen dataclass whose docstring, or that of its base, documents its fields

    In a graph file the fields are settings of the node. The function receives the group. A group that raises BadInput
    refuses its fields when the graph file is read.
    """

    def flatten(function: Callable[..., Any]) -> Callable[..., Any]:
        group = function.__annotations__[name]
        hints = get_type_hints(group, include_extras=True)
        fields = dataclasses.fields(group)
        names = {field.name for field in fields}

        def grouped(settings: dict[str, Any]) -> dict[str, Any]:
            own = {key: value for key, value in settings.items() if key not in names}
            return own | {name: group(**{key: value for key, value in settings.items() if key in names})}

        @wraps(function)
        def flat(*arguments: Any, **settings: Any) -> Any:
            return function(*arguments, **grouped(settings))

        parameters = []
        for parameter in inspect.signature(function).parameters.values():
            parameters += [keyword_of(field, hints) for field in fields] if parameter.name == name else [parameter]
        signature = inspect.signature(function).replace(parameters=parameters)
        flat.__signature__ = signature  # type: ignore[attr-defined]
        flat.grouped = grouped  # type: ignore[attr-defined]
        annotations = {parameter.name: parameter.annotation for parameter in parameters}
        flat.__annotations__ = {**annotations, "return": function.__annotations__["return"]}
        explained = (function, *(base for base in group.__mro__ if dataclasses.is_dataclass(base)))
        flat.__doc__ = "\n\n".join(inspect.cleandoc(item.__doc__ or "") for item in explained)
        return flat

    return flatten


def keyword_of(field: "dataclasses.Field[Any]", hints: dict[str, Any]) -> inspect.Parameter:
    """Return a field of a group as a keyword-only parameter."""
    default = inspect.Parameter.empty if field.default is dataclasses.MISSING else field.default
    return inspect.Parameter(field.name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=hints[field.name])
