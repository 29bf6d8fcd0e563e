"""What `make run` measures: a table of figures with their units and errors, and plots; each beside the words that make it."""
import html
import json
import math
import os
import subprocess
import sys

from tour_pictures import ATLAS, BRAIN, HEAD

OBJECTS = [
    ("Head", "all that has the value 45 or more", [HEAD, "--iso", "45"]),
    ("Brain", "60 or more, in the brain that was cut out", [BRAIN, "--iso", "60"]),
    ("Left precentral gyrus", "label 1 of the atlas, voxels counted", [ATLAS, "--label", "1"]),
]
PLOTS = [
    ("histogram", "A histogram", "How many samples have each value, by the logarithm; the threshold is that of the skin.", ["histogram", HEAD, "--iso", "45", "--log"]),
    ("profile", "A profile", "Values along a line from side to side: skin, skull, and the brain between.", ["profile", HEAD, "--space", "world", "--point=-90,-18,20", "--point=90,-18,20"]),
]

SECTION = """<section>
<h2>Measured</h2>
<p class="about">Figures come with their unit and, after ±, their standard error; areas and volumes are of Marching Cubes, those of labels are counted.</p>
<div class="table"><table>
<thead><tr><th></th>{heads}</tr></thead>
<tbody>
{rows}
</tbody>
</table></div>
{commands}
<div class="sheet plots">
{plots}
</div>
</section>"""

PLOT = """<figure>
<a href="{file}"><img src="{file}" width="960" height="600" loading="lazy" alt="{about}"></a>
<figcaption><b>{title}</b><span>{about}</span>
<pre>{command}</pre></figcaption>
</figure>"""

STYLE = """
.table { overflow-x: auto; background: var(--card); border: 1px solid var(--line); border-radius: .6rem; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { padding: .5rem .9rem; text-align: right; border-top: 1px solid var(--line); white-space: nowrap; }
thead th { border-top: 0; vertical-align: bottom; }
th:first-child { text-align: left; font-weight: 400; color: var(--soft); }
th small { display: block; font-weight: 400; color: var(--soft); white-space: normal; }
.plots { margin-top: 1.25rem; grid-template-columns: repeat(auto-fill, minmax(26rem, 1fr)); }
.plots figure img { aspect-ratio: 8 / 5; background: #fff; }
.commands { margin: .75rem 0 0; }
"""


def with_error(value, error, unit):
    """3234.3 ± 6.6 cm³: the error with two digits, and the value as far as it goes."""
    place = math.floor(math.log10(error)) - 1 if error > 0 else 0
    numbers = [f"{round(number, -place):,.{max(0, -place)}f}".replace(",", "\u202f") for number in (value, error)]
    return f"{numbers[0]} ± {numbers[1]} {unit}" if error > 0 else f"{numbers[0]} {unit}"


def rows_of(found):
    """One object's figures, by the names of the table's rows."""
    sides = " × ".join(f"{side:.1f}" for side in found["box_size"])
    return {
        "Area": with_error(found["area"] / 100, found["area_error"] / 100, "cm²"),
        "Volume": with_error(found["volume"] / 1000, found["volume_error"] / 1000, "cm³"),
        "Box": f"{sides} mm",
        "Samples": f"{found['count']:,}".replace(",", "\u202f"),
        "Mean value": with_error(found["mean"], found["standard_error"], ""),
        "Deviation": f"{found['deviation']:.2f}",
        "Median": f"{found['median']:g}",
    }


def run(program, words):
    done = subprocess.run([program, "measure", *words, "--json", "-q"], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"tour: cannot measure (exit {done.returncode}): {' '.join(words)}\n{done.stdout}{done.stderr}")
    return json.loads(done.stdout)


def section(program, out, shown):
    """The part of the page; plots lie in `out`. shown: a command line as text."""
    tables, commands = [], []
    for title, _, words in OBJECTS:
        found = run(program, words)
        same = found["unit"] == "mm" and found["area_unit"].startswith("mm") and found["volume_unit"].startswith("mm")
        if not same:
            sys.exit(f"tour: '{title}' is not measured in mm")
        table = rows_of(found)
        if "--label" in words:  # whose values are all the label's number
            table.update({name: "" for name in ("Mean value", "Deviation", "Median")})
        tables.append(table)
        commands.append(shown([program, "measure", *words]))
        print(f"  {'Measured: ' + title:44} {table['Volume']}", flush=True)
    rows = [
        f"<tr><th>{name}</th>" + "".join(f"<td>{html.escape(table[name])}</td>" for table in tables) + "</tr>" for name in tables[0]
    ]
    plots = []
    for name, title, about, words in PLOTS:
        command = [*words, "-o", os.path.join(out, name + ".svg")]
        run(program, [*command, "--overwrite"])
        plots.append(
            PLOT.format(file=name + ".svg", title=html.escape(title), about=html.escape(about), command=html.escape(shown([program, "measure", *command])))
        )
    heads = "".join(f"<th>{html.escape(title)}<small>{html.escape(about)}</small></th>" for title, about, _ in OBJECTS)
    return SECTION.format(
        heads=heads, rows="\n".join(rows), commands=f'<pre class="commands">{html.escape(chr(10).join(commands))}</pre>', plots="\n".join(plots)
    )
