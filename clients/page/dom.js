// Elements, sliders and numbers, made short.

/** An element with properties and children; `on...` and `aria-...` keys are what they say. */
export function el(tag, given = {}, ...children) {
  const made = document.createElement(tag);
  for (const [key, value] of Object.entries(given)) {
    if (key in made && !key.includes("-")) made[key] = value;
    else made.setAttribute(key, value);
  }
  made.append(...children.filter((each) => each !== null));
  return made;
}

/** A number as people write it: three digits that count. */
export function short(value) {
  const size = Math.abs(value);
  if (size >= 1e5 || (size > 0 && size < 1e-3)) return value.toExponential(1).replace("e+", "e");
  return String(Number(value.toPrecision(size >= 1000 ? 4 : 3)));
}

const STEPS = 1000;

/** Between a slider's place, 0 to 1, and a parameter's value: by ratios where the range is wide. */
export function scaleOf({ low, high, whole }) {
  const byRatio = low > 0 && high / low >= 30;
  const value = (share) => (byRatio ? low * (high / low) ** share : low + (high - low) * share);
  return {
    value: (share) => (whole ? Math.round(value(share)) : Number(value(share).toPrecision(4))),
    share: (x) => {
      const within = Math.min(high, Math.max(low, x));
      return byRatio ? Math.log(within / low) / Math.log(high / low) : (within - low) / (high - low);
    },
  };
}

/** A slider for a parameter. `now`: its value, null while it is as the preset has it; `usual`: the value then. */
export function slider(parameter, now, usual, onInput, onReset) {
  const { name, unit, help } = parameter;
  const scale = scaleOf(parameter);
  const label = name.replaceAll("_", " ");
  const shown = (value) => (value === null || value === undefined ? "preset" : `${short(value)}${unit ? ` ${unit.replace("semitones", "st")}` : ""}`);
  const out = el("output", { textContent: shown(now ?? usual) });
  const input = el("input", {
    type: "range", min: 0, max: STEPS, step: 1, value: STEPS * scale.share(now ?? usual ?? parameter.low),
    "aria-label": label, "aria-valuetext": shown(now ?? usual), title: help,
  });
  const row = el("label", { className: "slider" }, el("span", { textContent: label }), input, out);
  row.classList.toggle("as-preset", now === null || now === undefined);
  let before = now;
  input.oninput = () => {
    const value = scale.value(input.value / STEPS);
    out.textContent = shown(value);
    input.setAttribute("aria-valuetext", shown(value));
    row.classList.remove("as-preset");
    onInput(value, before);
  };
  input.onchange = () => (before = scale.value(input.value / STEPS));
  if (onReset) {
    row.ondblclick = (event) => {
      event.preventDefault();
      onReset();
    };
  }
  return row;
}
