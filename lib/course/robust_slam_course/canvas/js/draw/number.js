/** A number as a reader's text: at most `digits` significant digits, with a real minus sign. */
export function numberText(value, digits = 3) {
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  return String(Number(value.toPrecision(digits))).replace("-", "−");
}
