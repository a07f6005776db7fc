"""``hcss cache``: what is kept between runs."""

from __future__ import annotations

import json

import click

from hcss_twin.cache.kinds import OPTICS, PLANS, REFERENCES, TABLES

KINDS = dict((TABLES, PLANS, REFERENCES, OPTICS))


@click.group(invoke_without_command=True)
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
@click.pass_context
def cache(context: click.Context, as_json: bool) -> None:
    """Say what is kept between runs, where, and how large it is.

    Compiled tables of scenes and computed cloud optics come out the same in every run, so that they are kept in
    HCSS_CACHE_DIR, or in the user's cache folder. HCSS_CACHE_MB limits the tables (1000 MB; 0 keeps none).
    """
    if context.invoked_subcommand is not None:
        return
    from hcss_twin.cache.folder import cache_root
    from hcss_twin.cache.store import Store, limit_bytes

    root, limit = cache_root(), limit_bytes()
    found = {kind: Store(kind, suffix).kept() for kind, suffix in KINDS.items()}
    if as_json:
        sizes = {
            kind: {"files": len(files), "bytes": sum(each.size for each in files)}
            for kind, files in found.items()
        }
        click.echo(
            json.dumps({"folder": None if root is None else str(root), "limit_bytes": limit, "kinds": sizes})
        )
        return
    click.echo(f"{'no folder to keep anything in' if root is None else root}")
    for kind, files in found.items():
        most = f" of at most {limit / 1e6:g} MB" if kind == TABLES[0] else ""
        click.echo(f"  {kind:<11}{len(files):5} files {sum(each.size for each in files) / 1e6:9.2f} MB{most}")


@cache.command()
@click.argument("kinds", nargs=-1, type=click.Choice(sorted(KINDS)))
def clear(kinds: tuple[str, ...]) -> None:
    """Remove what is kept: all of it, or the KINDS named."""
    from hcss_twin.cache.store import Store

    for kind in kinds or KINDS:
        removed = Store(kind, KINDS[kind]).clear()
        click.echo(f"{kind}: {len(removed)} files removed, {sum(each.size for each in removed) / 1e6:.1f} MB")
