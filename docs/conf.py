"""The documentation site: ``python -m sphinx -q -W --keep-going -c docs . build/site`` (extra ``docs``).

Pages are plain Markdown that a code host shows as it is. The source folder is the repository, so that their links
to the changes, the catalogs and the plugins are those of the checkout. The navigation is the list of links in
docs/index.md: a new page needs one line there, and -W makes pages without one, broken links and links to missing
headings errors.
"""

import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent / "site"), str(Path(__file__).parents[1])]

from hcss_twin.version import __version__  # noqa: E402

project = "hcss_twin"
author = "The hcss_twin developers"
copyright = author
version = release = __version__
language = "en"

extensions = ["myst_parser", "navigation", "offline_math", "only_local_files"]
include_patterns = [
    "docs/**",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "catalogs/README.md",
    "catalogs/*/README.md",
    "plugins/*/README.md",
]
exclude_patterns = ["docs/site/**"]
root_doc = "docs/index"

myst_heading_anchors = 4
myst_enable_extensions = ["dollarmath"]
suppress_warnings = ["config.cache"]

html_theme = "furo"
html_title = f"hcss_twin {release}"
html_math_renderer = "mathml"
html_static_path = ["site/static"]
html_css_files = ["site.css"]
html_extra_path = ["site/root"]
html_show_sourcelink = False
html_copy_source = False
pygments_style = "default"
pygments_dark_style = "github-dark"
