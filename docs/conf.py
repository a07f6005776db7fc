"""Build the documentation site: ``python -m sphinx -q -W --keep-going -c docs . build/site`` (extra ``docs``).

Pages are plain Markdown that a code host can display. The source folder is the repository, so that pages can link to
the change log, the catalogs and the plugins. The links in docs/index.md define the navigation. With -W, unlisted
pages, broken links and links to missing headings are errors.
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
    "plugins/hcss-dataset/train-a-detector.md",
    "plugins/hcss-payload/LIVE.md",
    "plugins/hcss-payload/TUTORIAL.md",
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
