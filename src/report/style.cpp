// SPDX-License-Identifier: Apache-2.0
#include "report/page.hpp"

namespace splinevox::run {

const char* report_style() {
  return R"css(
:root { --ink:#1c2530; --soft:#5d6b7a; --faint:#94a1af; --line:#e3e8ee; --paper:#f5f7f9; --card:#fff;
  --c0:#2463eb; --c1:#e4572e; --c2:#12936f; --c3:#9b45b2; --c4:#c58a00; --c5:#0fa3b8; --c6:#d6336c; --c7:#6b7785; }
@media (prefers-color-scheme: dark) { :root { --ink:#e7ecf2; --soft:#a3b0be; --faint:#74818f; --line:#2b3540;
  --paper:#12171d; --card:#1a2129; --c0:#6b9bff; --c1:#ff8a66; --c2:#3ecf9f; --c3:#cf86e3; --c4:#f0bb3e; --c5:#4fd0e2;
  --c6:#ff7aa5; --c7:#9aa7b5; } }
* { box-sizing:border-box }
body { margin:0; background:var(--paper); color:var(--ink); font:15px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,"DejaVu Sans",sans-serif }
main { max-width:1240px; margin:0 auto; padding:36px 28px 60px }
header h1 { font-size:30px; letter-spacing:-.02em; margin:0 }
header p { color:var(--soft); margin:4px 0 26px }
h2 { font-size:19px; letter-spacing:-.01em; margin:38px 0 12px }
h3 { font-size:15px; margin:20px 0 8px }
.card h3:first-child { margin-top:0 }
.run-name i { display:inline-block; width:11px; height:11px; border-radius:3px; margin-right:8px; background:var(--c) }
.card, .chart, .tile, .views figure { background:var(--card); border:1px solid var(--line); border-radius:12px }
.card { padding:18px 20px; margin-bottom:14px }
.tiles { display:grid; grid-template-columns:repeat(auto-fit,minmax(126px,1fr)); gap:12px; margin-bottom:18px }
.tile { padding:12px 14px }
.tile b { display:block; font-size:22px; font-weight:650; white-space:nowrap; letter-spacing:-.02em; font-variant-numeric:tabular-nums }
.tile b small { font-size:13px; font-weight:500; color:var(--soft); margin-left:4px; letter-spacing:0 }
.tile span { color:var(--soft); font-size:13px }
.charts { display:grid; grid-template-columns:repeat(auto-fit,minmax(350px,1fr)); gap:14px }
.chart { margin:0; padding:16px 16px 10px }
.chart figcaption { font-weight:600; margin-bottom:6px }
.chart div { position:relative; height:300px }
.chart:first-child { grid-column:1/-1 }
.c0{--c:var(--c0)} .c1{--c:var(--c1)} .c2{--c:var(--c2)} .c3{--c:var(--c3)} .c4{--c:var(--c4)} .c5{--c:var(--c5)} .c6{--c:var(--c6)} .c7{--c:var(--c7)}
.legend { margin:8px 0 0; color:var(--soft); font-size:13px } .legend span { margin-right:18px; white-space:nowrap }
.key-dot { display:inline-block; vertical-align:middle; margin-right:6px; background:var(--c) }
.key-dot { width:10px; height:10px; border-radius:3px }
.stack { display:flex; height:24px; border-radius:7px; overflow:hidden; background:var(--line) }
.stack i { background:var(--c); min-width:1px }
table { border-collapse:collapse; width:100%; font-variant-numeric:tabular-nums }
th { text-align:right; font-weight:600; color:var(--soft); font-size:13px } td { text-align:right }
th,td { padding:6px 12px; border-bottom:1px solid var(--line) } tr:last-child td { border-bottom:0 }
th:first-child, td:first-child { text-align:left } td.best { font-weight:700 }
.note { color:var(--soft); font-size:13.5px; margin:0 0 10px }
.views { display:grid; grid-template-columns:repeat(auto-fit,minmax(540px,1fr)); gap:14px }
.views figure { margin:0; padding:14px; overflow:hidden }
.views .row { display:grid; grid-template-columns:repeat(auto-fit,minmax(90px,1fr)); gap:8px }
.views .row div { text-align:center; font-size:12.5px; color:var(--soft) }
.views img { width:100%; display:block; border-radius:7px; border:1px solid var(--line); background:#fff }
.views figcaption { display:flex; gap:16px; margin-bottom:9px; color:var(--soft); font-size:13.5px } .views figcaption b { color:var(--ink) }
details { margin-top:12px } summary { cursor:pointer; color:var(--soft) }
pre { overflow:auto; font:12.5px/1.45 ui-monospace,"DejaVu Sans Mono",monospace; margin:10px 0 0 }
footer { color:var(--faint); font-size:13px; margin-top:44px }
@media (max-width:560px) { main { padding:22px 14px } .charts, .views { grid-template-columns:1fr } }
)css";
}

}  // namespace splinevox::run
