const es = new EventSource("events");
es.addEventListener("picture", async () => {
  const r = await fetch("picture"); const [w,h] = r.headers.get("X-Picture").split(" ").map(Number);
  const c = document.getElementById("c"); c.width = w; c.height = h;
  c.getContext("2d").putImageData(new ImageData(new Uint8ClampedArray(await r.arrayBuffer()), w, h), 0, 0);
});
