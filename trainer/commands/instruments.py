"""The command that tells what is sent to instruments."""

import click


@click.command()
@click.option("--sample", is_flag=True, help="Print one set, of the bb2 in trim.")
@click.option("--json", "as_json", is_flag=True, help="Print it as JSON.")
def instruments(*, sample: bool, as_json: bool) -> None:
    """List the NMEA 0183 sentences sent by `--nmea`: their fields, units and sources.

    \b
    Example:  trainer instruments --sample
              trainer run --nmea udp://127.0.0.1:10110
              trainer serve --nmea /dev/ttyUSB0 --nmea-baud 4800 --nmea-sentences HDT,DPT,ROT
    """
    import json  # noqa: PLC0415

    from trainer.files.vessel_file import load_vessel  # noqa: PLC0415
    from trainer.nmea import page as nmea_page  # noqa: PLC0415

    if sample:
        lines = nmea_page.sample(load_vessel("bb2"))
        click.echo(json.dumps(lines, indent=1) if as_json else "\n".join(lines))
        return
    click.echo(json.dumps(nmea_page.as_json(), indent=1) if as_json else nmea_page.page())
