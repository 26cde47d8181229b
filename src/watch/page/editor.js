// Where the page stands in an editor's panel, places are shown in the editor: a message
// {source: "scnrender", type: "reveal", file, line, column} goes to the panel.
export const reveal = window.parent === window ? null : ({ file, line, column }) => {
  window.parent.postMessage({ source: "scnrender", type: "reveal", file, line, column }, "*");
};
