// Light or dark: the system's choice until the reader picks one, which is kept. Colours of drawings come from the style sheet.

const KEY = 'morphograph-theme';
const dark = matchMedia('(prefers-color-scheme: dark)');
const listeners: (() => void)[] = [];

function stored(): string | null {
  try {
    return localStorage.getItem(KEY);
  } catch {
    return null; // storage may be forbidden
  }
}

function apply(theme: string | null): void {
  document.documentElement.dataset.theme = theme ?? (dark.matches ? 'dark' : 'light');
  for (const listener of listeners) listener();
}

export function startTheme(button: HTMLElement): void {
  apply(stored());
  dark.addEventListener('change', () => stored() ?? apply(null));
  button.addEventListener('click', () => {
    const theme = document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark';
    try {
      localStorage.setItem(KEY, theme);
    } catch { /* the choice then lasts as long as the page */ }
    apply(theme);
  });
}

export function onTheme(listener: () => void): void {
  listeners.push(listener);
}

/** A colour of the style sheet, by the name of its custom property. */
export function themeColour(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}
