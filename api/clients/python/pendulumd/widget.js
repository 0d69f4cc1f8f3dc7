// A pendulum in a notebook, by anywidget's protocol: the embed view of the page (its stage and its engine) in a frame.
// Leaves to others: the view (/?embed=1, api/guide/embedding.md), the traits (widget.py).
// Invariant: what the frame reports is saved to the model; what Python sets goes to the frame; no echo of either comes back.
export default {
  render({ model, el }) {
    const view = new URL("?embed=1", model.get("url"));
    const frame = document.createElement("iframe");
    Object.assign(frame, { src: view.href, title: "Pendulum", width: "100%", height: model.get("height") });
    frame.style.border = "0";
    let ready = false;
    let known = "";
    const set = () => {
      const { scene, time, playing } = Object.fromEntries(["scene", "time", "playing"].map((name) => [name, model.get(name)]));
      if (!ready || JSON.stringify([scene, time, playing]) === known) return;
      frame.contentWindow.postMessage({ pendulumd: "set", scene, time, playing }, view.origin);
    };
    const heard = ({ data, source }) => {
      if (source !== frame.contentWindow || data?.pendulumd !== "state") return;
      if (!ready) {
        ready = true; // the first state is that of an empty page
        set();
        return;
      }
      known = JSON.stringify([data.scene, data.time, data.playing]);
      for (const name of ["scene", "time", "playing"]) model.set(name, data[name]);
      model.save_changes();
    };
    window.addEventListener("message", heard);
    for (const name of ["scene", "time", "playing"]) model.on(`change:${name}`, set);
    el.append(frame);
    return () => {
      window.removeEventListener("message", heard);
      for (const name of ["scene", "time", "playing"]) model.off(`change:${name}`, set);
    };
  },
};
