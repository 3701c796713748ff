'use strict';
// The page tells its own state, so that a test can read it from the document:
// data-errors counts what went wrong, data-ready is 1 once everything runs.
(() => {
  const root = document.documentElement;
  root.dataset.errors = '0';
  const count = () => { root.dataset.errors = String(Number(root.dataset.errors) + 1); };
  addEventListener('error', count);
  addEventListener('unhandledrejection', count);
  addEventListener('securitypolicyviolation', count);
  // Settings after the # of the address: play, step=40, episode=2, uav=7, theme=dark.
  globalThis.covey = { settings: new URLSearchParams(location.hash.slice(1)) };
  const theme = covey.settings.get('theme');
  if (theme === 'dark' || theme === 'light') root.dataset.theme = theme;
})();
