// SPDX-License-Identifier: BSD-3-Clause
// The axes of a chart: their ranges and round values.

import { axisName, formatFigure } from "./words";

export interface Range {
  min: number;
  max: number;
}

/** The values between which an axis goes, with some room at both ends. */
export function axisRange(values: number[], log: boolean): Range {
  if (values.length === 0) return { min: log ? 1 : 0, max: log ? 10 : 1 };
  const low = Math.min(...values);
  const high = Math.max(...values);
  if (log) {
    const room = Math.max(1.15, (high / low) ** 0.06);
    return { min: low / room, max: high * room };
  }
  const room = high > low ? 0.07 * (high - low) : Math.abs(high) * 0.1 || 1;
  return { min: low >= 0 ? Math.max(0, low - room) : low - room, max: high + room };
}

/** Round values within a range: 1, 2, 5 times powers of ten on a log axis. */
export function ticks({ min, max }: Range, log: boolean): number[] {
  const result: number[] = [];
  if (log) {
    const decades = Math.log10(max / min);
    const digits =
      decades > 3 ? [1] : decades > 0.7 ? [1, 2, 5] : [1, 1.5, 2, 3, 4, 5, 6, 7, 8, 9];
    for (let e = Math.floor(Math.log10(min)); e <= Math.log10(max); ++e) {
      for (const digit of digits) {
        const value = Number(`${digit}e${e}`);
        if (value >= min && value <= max) result.push(value);
      }
    }
    return result.length < 3 ? ticks({ min, max }, false) : result;
  }
  const rough = (max - min) / 7;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5, 10].find((digit) => digit * power >= rough) ?? 10);
  for (let i = Math.ceil(min / step); i * step <= max; ++i) {
    result.push(Number((i * step).toPrecision(12)));
  }
  return result;
}

export function axis(
  name: string,
  words: string | undefined,
  range: Range,
  log: boolean,
  gridIndex: number,
) {
  const values = ticks(range, log);
  return {
    gridIndex,
    type: log ? ("log" as const) : ("value" as const),
    min: range.min,
    max: range.max,
    name: words ?? axisName(name),
    nameLocation: "middle" as const,
    axisLabel: {
      customValues: values,
      formatter: (value: number) => formatFigure(name, value),
      hideOverlap: true,
    },
    axisTick: { customValues: values },
    axisLine: { show: true, onZero: false },
    splitLine: { lineStyle: { color: "#eeeeee" } },
  };
}
