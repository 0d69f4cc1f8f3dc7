import { h } from "../dom.js";

export default {
  id: "modes",
  title: (text) => text("drawer.modes"),
  mount(element, { text }) {
    element.append(h("h2", {}, text("drawer.modes")));
    return { show() {}, hide() {}, destroy: () => element.replaceChildren() };
  },
};
