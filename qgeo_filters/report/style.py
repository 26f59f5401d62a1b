"""The stylesheet of the report: light and dark, wide and narrow, on screen and on paper."""

STYLESHEET = """
:root {
  --page: #f6f6f4; --card: #ffffff; --text: #1d2026; --faint: #5d6470; --line: #dfe1e5; --accent: #2c5fa8;
}
@media (prefers-color-scheme: dark) {
  :root { --page: #14161a; --card: #1e2127; --text: #e8eaee; --faint: #a2a9b5; --line: #343943; --accent: #8db4e2; }
}
* { box-sizing: border-box; }
body {
  margin: 0 auto; padding: 2rem clamp(1rem, 4vw, 3rem) 3rem; max-width: 70rem;
  background: var(--page); color: var(--text);
  font: 1rem/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", sans-serif;
}
header { border-bottom: 3px solid var(--accent); margin-bottom: 1.5rem; padding-bottom: .75rem; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: 0; overflow-wrap: anywhere; }
header p { margin: .35rem 0 0; color: var(--faint); overflow-wrap: anywhere; }
h2 { font-size: 1.05rem; margin: 0 0 .6rem; }
.pictures { display: grid; gap: 1.25rem; align-items: start; grid-auto-flow: dense;
  grid-template-columns: repeat(auto-fit, minmax(min(24rem, 100%), 1fr)); }
figure, .table { margin: 0; background: var(--card); border: 1px solid var(--line); border-radius: .6rem;
  overflow: hidden; }
figure.wide, figure.alone { grid-column: 1 / -1; }
figure.alone img { object-fit: scale-down; }
/* The pictures are made for white paper: they keep it at night, as cards of their own, and their colours, which legends
   name, are left alone. */
figure img {
  display: block; width: 100%; max-height: 44rem; object-fit: contain; background: #ffffff; padding: .75rem;
}
@media (prefers-color-scheme: dark) {
  figure { padding: .75rem .75rem 0; }
  figure img { border-radius: .4rem; }
  figcaption { border-top: 0; padding-inline: .25rem; }
}
figcaption { padding: .7rem 1rem .8rem; border-top: 1px solid var(--line); font-size: .92rem;
  color: var(--faint); }
.tables { columns: 2 24rem; column-gap: 1.25rem; margin-top: 1.25rem; }
.table { break-inside: avoid; margin-bottom: 1.25rem; }
.table { padding: 1rem; }
.table.wide { column-span: all; }
.table.wide:not(:first-child) { margin-top: 1.25rem; }
.table p { margin: .6rem 0 0; font-size: .9rem; color: var(--faint); }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: .92rem; }
th, td { text-align: left; padding: .32rem .8rem .32rem 0; border-top: 1px solid var(--line);
  vertical-align: top; overflow-wrap: anywhere; }
thead th, tr:first-child > * { border-top: 0; }
thead + tbody tr:first-child > * { border-top: 1px solid var(--line); }
th { overflow-wrap: break-word; }
thead th { color: var(--faint); font-weight: 600; }
tbody th { font-weight: 500; }
.number { font-variant-numeric: tabular-nums; white-space: nowrap; }
.meaning { color: var(--faint); font-size: .88rem; }
.meaning { width: 46%; padding-right: 0; }
table:not(:has(.meaning)) .sentence { min-width: 14rem; }  /* else a narrow page leaves it a letter a line */
@media (max-width: 46rem) {  /* what a number means stands under its row, which has a column for each mesh */
  .explained tr { display: flex; flex-wrap: wrap; border-top: 1px solid var(--line); }
  .explained table tr > *, .explained thead + tbody tr:first-child > * { border-top: 0; flex: 1 1 0; min-width: 0;
    padding-bottom: 0; }
  .explained thead tr { border-top: 0; }
  .explained tbody tr:nth-child(n) > .meaning { flex-basis: 100%; padding: 0 0 .35rem; }
  .explained thead th:empty:last-child { display: none; }
  /* Long names of files are broken: else what they hold lies out of sight. */
  table:not(:has(.meaning)) .sentence { min-width: 10rem; }
  table:not(:has(.meaning)):has(.sentence) tbody th { min-width: 8rem; overflow-wrap: anywhere; }
}
a { color: var(--accent); }
footer { margin-top: 1.5rem; font-size: .88rem; color: var(--faint); overflow-wrap: anywhere; }
@page { margin: 14mm; }
@media print {
  :root { --page: #ffffff; --card: #ffffff; --text: #000000; --faint: #444444; --line: #bbbbbb; --accent: #1d4580;
    color-scheme: light; }
  body { padding: 0; max-width: none; font-size: 10pt; }
  .pictures { grid-template-columns: repeat(2, minmax(0, 1fr)); }
  figure, .table, tr { break-inside: avoid; }
  /* A long one would leave a page half empty before it. */
  .table:has(tr:nth-child(9)) { break-inside: auto; -webkit-box-decoration-break: clone; box-decoration-break: clone; }
  h2, thead { break-after: avoid; }
  figure, .table { border-radius: 0; }
  figure { padding: 0; }
  figure img { max-height: 10.5cm; }
  h1 { break-after: avoid; }
  .tables { columns: auto; }
  footer { break-before: avoid; }
  table { font-size: 8.5pt; }
  .meaning { width: 40%; font-size: 8pt; }
  .scroll { overflow: visible; }
  table:not(:has(.meaning)) .sentence { min-width: 0; }
}
"""
