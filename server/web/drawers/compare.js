import { h } from "../dom.js";

export default {
  id: "compare",
  title: (text) => text("drawer.compare"),
  mount(element, { text }) {
    element.append(h("h2", {}, text("drawer.compare")));
    return { show() {}, hide() {}, destroy: () => element.replaceChildren() };
  },
};
