#include "experiments/report/html.h"

#include <algorithm>

namespace raylex::experiments {

std::string escape_html(std::string_view text) {
    std::string result;
    result.reserve(text.size());
    for (const char c : text) {
        switch (c) {
            case '&':
                result += "&amp;";
                break;
            case '<':
                result += "&lt;";
                break;
            case '>':
                result += "&gt;";
                break;
            case '"':
                result += "&quot;";
                break;
            case '\'':
                result += "&#39;";
                break;
            default:
                result += static_cast<unsigned char>(c) < 32 && c != '\n' && c != '\t' ? ' ' : c;
        }
    }
    return result;
}

std::string base64(std::span<const unsigned char> bytes) {
    static constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string result;
    result.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
        unsigned bits = static_cast<unsigned>(bytes[i]) << 16;
        if (count > 1) bits |= static_cast<unsigned>(bytes[i + 1]) << 8;
        if (count > 2) bits |= bytes[i + 2];
        result += letters[bits >> 18 & 63];
        result += letters[bits >> 12 & 63];
        result += count > 1 ? letters[bits >> 6 & 63] : '=';
        result += count > 2 ? letters[bits & 63] : '=';
    }
    return result;
}

std::string data_uri(std::span<const unsigned char> png) {
    return "data:image/png;base64," + base64(png);
}

std::string_view page_style() {
    return R"css(
:root { color-scheme: light dark; --paper: #fbfaf8; --ink: #1d1c1a; --faint: #6c6862; --line: #dedad3;
  --card: #ffffff; --mark: #9a4a12;
  --good: #1c6b3c; --bad: #b3261e; --well: #14130f; }
@media (prefers-color-scheme: dark) { :root { --paper: #171614; --ink: #e9e6e0; --faint: #9d978d; --line: #35322d;
  --card: #1f1d1a; --mark: #e59a5c;
  --good: #7cc79a; --bad: #ff8f85; --well: #0c0b0a; } }
* { box-sizing: border-box; }
body { margin: 0; padding: 2rem clamp(1rem, 3vw, 3rem) 4rem; background: var(--paper); color: var(--ink);
  font: 15px/1.5 system-ui, "DejaVu Sans", sans-serif; }
h1 { font-size: 1.5rem; margin: 0 0 .2rem; font-weight: 650; }
h2 { font-size: 1.2rem; margin: 3rem 0 .2rem; padding-top: 1.2rem; border-top: 1px solid var(--line);
  font-weight: 650; overflow-wrap: anywhere; }
h3 { font-size: .95rem; margin: 1.6rem 0 .5rem; font-weight: 650; }
p { margin: .2rem 0 .6rem; } .faint { color: var(--faint); } code, pre { font: 12.5px/1.45 ui-monospace,
  "DejaVu Sans Mono", monospace; }
.holds { color: var(--good); font-weight: 650; } .fails { color: var(--bad); font-weight: 650; }
.scene { display: grid; gap: 1.5rem; grid-template-columns: minmax(0, 3fr) minmax(17rem, 2fr); align-items: start; }
@media (max-width: 56rem) { .scene { grid-template-columns: minmax(0, 1fr); } }
.viewer { position: sticky; top: 1rem; }
.viewer .well { background: var(--well); border-radius: 6px; overflow: hidden; line-height: 0; }
.viewer .well img { width: 100%; height: auto; max-height: 74vh; object-fit: contain; image-rendering: auto; }
.viewer figcaption { display: flex; gap: .8rem; align-items: baseline; flex-wrap: wrap; padding: .5rem 0 0; }
.viewer .name { font-weight: 650; } .viewer .expression { color: var(--mark); overflow-wrap: anywhere; }
figure { margin: 0; }
.controls { margin-left: auto; display: flex; gap: .3rem; }
button { font: inherit; color: inherit; background: var(--card); border: 1px solid var(--line); border-radius: 5px;
  padding: .1rem .6rem; cursor: pointer; }
button[aria-pressed="true"] { border-color: var(--mark); color: var(--mark); }
button:focus-visible, .layer:focus-visible { outline: 2px solid var(--mark); outline-offset: 2px; }
.layers { display: grid; gap: .7rem; align-items: start;
  grid-template-columns: repeat(auto-fill, minmax(8.5rem, 1fr)); }
.layer { display: block; width: 100%; text-align: left; padding: 0; border: 1px solid var(--line);
  border-radius: 6px; background: var(--card); overflow: hidden; }
.layer img { display: block; width: 100%; height: auto; background: var(--well); }
.layer span { display: block; padding: .25rem .5rem .35rem; font-size: 13px; overflow-wrap: anywhere; }
.layer code { display: block; color: var(--faint); font-size: 11.5px; overflow-wrap: anywhere; }
.layer.empty img { height: 2.2rem; object-fit: cover; }
.layer[aria-pressed="true"] { border-color: var(--mark); box-shadow: 0 0 0 1px var(--mark); }
.wide { overflow-x: auto; margin-bottom: 1rem; } .tables { display: flex; flex-wrap: wrap; gap: .5rem 3rem;
  align-items: flex-start; }
table { border-collapse: collapse; font-size: 13.5px; } th { text-align: left; font-weight: 600;
  color: var(--faint); }
td, th { padding: .2rem .9rem .2rem 0; vertical-align: top; border-bottom: 1px solid var(--line); }
  td.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
td { overflow-wrap: anywhere; } td:first-child { white-space: nowrap; }
details { margin: 1rem 0; } summary { cursor: pointer; font-weight: 600; } pre { overflow-x: auto; padding: .8rem;
  background: var(--card); border: 1px solid var(--line); border-radius: 6px; }
)css";
}

std::string_view page_script() {
    return R"js(
(() => {
  const scenes = [...document.querySelectorAll('section.image:has(.layer)')].map(section => {
    const layers = [...section.querySelectorAll('.layer')];
    const picture = section.querySelector('.well img'), name = section.querySelector('.name'),
      text = section.querySelector('.expression');
    const exposure = [...section.querySelectorAll('[data-exposure]')];
    let current = 0, bright = false;
    const show = () => {
      const layer = layers[current], small = layer.querySelector('img');
      const lifted = small.dataset.bright;
      picture.src = bright && lifted ? lifted : small.src;
      picture.alt = small.alt;
      name.textContent = layer.dataset.name + (bright && lifted ? ' (+3 stops)' : '');
      text.textContent = layer.dataset.expression || layer.dataset.look || '';
      layers.forEach((each, i) => each.setAttribute('aria-pressed', String(i === current)));
      exposure.forEach(each => each.setAttribute('aria-pressed', String((each.dataset.exposure === '3') === bright)));
    };
    layers.forEach((each, i) => each.addEventListener('click', () => { current = i; show(); }));
    exposure.forEach(each => each.addEventListener('click', () => { bright = each.dataset.exposure === '3'; show();
  }));
    show();
    return { section, step: by => { current = (current + by + layers.length) % layers.length; show(); },
             toggle: () => { bright = !bright; show(); }, beauty: () => { current = 0; show(); } };
  });
  const visible = () => {
    let best = scenes[0], most = -1;
    for (const each of scenes) {
      const box = each.section.getBoundingClientRect();
      const seen = Math.min(box.bottom, innerHeight) - Math.max(box.top, 0);
      if (seen > most) { most = seen; best = each; }
    }
    return best;
  };
  addEventListener('keydown', event => {
    if (event.ctrlKey || event.altKey || event.metaKey || !scenes.length) return;
    if (event.key === 'ArrowRight') visible().step(1);
    else if (event.key === 'ArrowLeft') visible().step(-1);
    else if (event.key === 'e') visible().toggle();
    else if (event.key === 'b') visible().beauty();
    else return;
    event.preventDefault();
  });
})();
)js";
}

}  // namespace raylex::experiments
