import { h } from "../dom.js";

export default {
  id: "plots",
  title: (text) => text("drawer.plots"),
  mount(element, { text }) {
    element.append(h("h2", {}, text("drawer.plots")));
    return { show() {}, hide() {}, destroy: () => element.replaceChildren() };
  },
};
