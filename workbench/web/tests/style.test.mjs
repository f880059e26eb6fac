// Colours of the page: texts and controls are seen against what is behind them, in light and dark.

import assert from "node:assert/strict";
import fs from "node:fs";
import test from "node:test";

const style = fs.readFileSync(new URL("../style.css", import.meta.url), "utf8");

/** Relative luminance of a colour (WCAG 2.2). */
function luminance(colour) {
  const digits = colour.length === 4 ? [...colour.slice(1)].map((own) => own + own) : colour.slice(1).match(/../g);
  const [r, g, b] = digits.map((own) => parseInt(own, 16) / 255)
    .map((x) => (x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4));
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

function contrast(one, other) {
  const [dark, light] = [luminance(one), luminance(other)].sort((a, b) => a - b);
  return (light + 0.05) / (dark + 0.05);
}

test("texts have a contrast of at least 4.5, controls of 3", () => {
  const blocks = [...style.matchAll(/:root \{([^}]*)\}/g)].map(([, own]) => own);
  assert.equal(blocks.length, 2, "light and dark");
  for (const block of blocks) {
    const colour = Object.fromEntries([...block.matchAll(/--([\w-]+): (#\w+)/g)].map(([, name, value]) => [name, value]));
    for (const text of ["text", "quiet", "good", "bad", "warn", "accent"]) {
      for (const ground of ["ground", "panel"]) {
        const found = contrast(colour[text], colour[ground]);
        assert.ok(found >= 4.5, `${text} on ${ground}: ${found.toFixed(2)}`);
      }
    }
    assert.ok(contrast(colour["on-accent"], colour.accent) >= 4.5, "button");
    // The border of a field, and the focus.
    for (const edge of ["quiet", "accent"]) assert.ok(contrast(colour[edge], colour.ground) >= 3, edge);
  }
});
