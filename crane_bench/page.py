"""Pages of documentation from templates of Jinja2, the files in `pages`."""

from typing import Any

from crane_sim.files.installation import import_optional


def fill_page(name: str, **values: Any) -> str:
    """Return the page in Markdown that the template of this name makes of values."""
    jinja2 = import_optional("jinja2", "a page")
    pages = jinja2.Environment(
        loader=jinja2.PackageLoader("crane_bench", "pages"),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )
    return pages.get_template(f"{name}.md").render(values)
