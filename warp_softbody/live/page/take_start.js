// Unpacks the take and the player that are in this page.

async function unpacked(id) {
  const text = document.getElementById(id).textContent;
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

async function start() {
  const [player, take] = await Promise.all([unpacked("player"), unpacked("take")]);
  window.takeBytes = take;
  const script = document.createElement("script");
  script.type = "module";
  script.textContent = new TextDecoder().decode(player);
  document.body.append(script);
}

start();
